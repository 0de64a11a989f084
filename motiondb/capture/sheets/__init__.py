"""Sheets of words and of events."""
