"""Captures and words into the store, and out of it."""
