"""Measurements of scenes."""
