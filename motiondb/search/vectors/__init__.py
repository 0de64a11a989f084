"""Vectors that describe an interval of motion."""
