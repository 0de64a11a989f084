"""Measurements of the grammar learner."""
