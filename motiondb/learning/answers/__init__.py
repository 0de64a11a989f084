"""Answers to questions, computed from what was learned."""
