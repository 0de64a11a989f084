"""Answers of the class as JSON."""
