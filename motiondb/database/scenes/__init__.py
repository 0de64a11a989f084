"""The verbs of scenes."""
