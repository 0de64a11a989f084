"""Readers of the capture formats, one format a module."""
