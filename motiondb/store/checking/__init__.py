"""Check the file, rescue what is readable from a damaged one, and compact it."""
