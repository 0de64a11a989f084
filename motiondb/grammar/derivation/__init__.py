"""Sentences derived from a grammar: at random, by editing a region, or towards a goal."""
