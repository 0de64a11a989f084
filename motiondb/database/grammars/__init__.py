"""Verbs of motion grammars."""
