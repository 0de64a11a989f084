"""Certainty of answers and places, learned from questions with known answers."""
