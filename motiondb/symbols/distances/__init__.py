"""Distances between symbols, the space that approximates them, and its clusters."""
