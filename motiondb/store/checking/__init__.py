"""Check the file, rescue the readable parts of a damaged one, and compact it."""
