"""Captures with their files, motions, words, events and origins, and the cache of motions."""
