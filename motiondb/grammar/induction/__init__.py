"""Rules from sentences: alignment-based learning, then a compiled search for fewer bits."""
