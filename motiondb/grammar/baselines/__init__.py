"""Simpler grammars to compare with, and measures of languages."""
