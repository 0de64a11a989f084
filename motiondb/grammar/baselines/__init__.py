"""Baseline grammars, and measures that compare languages."""
