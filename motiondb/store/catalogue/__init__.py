"""Captures with their files, motions, captions, events and provenance; the cache of motions."""
