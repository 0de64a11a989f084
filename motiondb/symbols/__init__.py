"""Motion symbols: segments of captures, their hidden Markov models, distances and clusters."""
