"""Checks of a motion grammar, and plans of action strings."""
