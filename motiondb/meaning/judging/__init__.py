"""The judge of generated motion."""
