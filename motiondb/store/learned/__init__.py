"""The tables that ``learn`` replaces: segments, symbols, their space, and their words."""
