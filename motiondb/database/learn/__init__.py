"""Learn from the store, and update the learned model when captures change."""
