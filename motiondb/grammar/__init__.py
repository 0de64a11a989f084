"""Grammars of movement: learned from long takes, used to parse, derive and edit motion."""
