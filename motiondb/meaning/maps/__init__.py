"""Maps from motion to words, and the vectors they take."""
