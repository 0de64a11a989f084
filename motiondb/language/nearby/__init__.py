"""Words that may stand for a word that no caption holds."""
