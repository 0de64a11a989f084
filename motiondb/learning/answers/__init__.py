"""Answers to questions, computed from the learned model."""
