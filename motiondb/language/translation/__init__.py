"""Association of symbols and words, and decoding."""
