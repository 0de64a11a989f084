"""Learning from captures, and computations from the learned model: arrays in, arrays out."""
