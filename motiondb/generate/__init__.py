"""New motion from a sentence."""
