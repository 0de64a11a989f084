"""Vectors of words, by which words and sentences are compared in meaning."""
