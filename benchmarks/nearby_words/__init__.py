"""The key of nearby words, what WordNet says of pairs of words, and how answers are judged."""
