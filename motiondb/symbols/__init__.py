"""Motion symbols: segments, hidden Markov models, discovery, distances."""
