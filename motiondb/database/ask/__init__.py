"""Answers to questions in words and by example."""
