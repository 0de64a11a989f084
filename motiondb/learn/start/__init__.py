"""Learning that begins from the knowledge of another database."""
