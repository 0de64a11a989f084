"""Sentences cut from the strings of long takes: cuts, their search, and description length."""
