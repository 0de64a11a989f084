"""Rules from sentences: a compiled search for fewer bits."""
