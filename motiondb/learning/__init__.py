"""What is learned from captures, and what follows from it: arrays in, arrays out."""
