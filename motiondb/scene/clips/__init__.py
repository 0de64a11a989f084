"""Captures cut into clips, their variants, and the cost of joining them."""
