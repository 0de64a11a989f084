"""Segments of captures before there are symbols, and activities of long takes."""
