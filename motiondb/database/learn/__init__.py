"""Learn from the store, and keep what was learned true."""
