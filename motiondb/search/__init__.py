"""Answers to questions and examples, with reasons and certainty."""
