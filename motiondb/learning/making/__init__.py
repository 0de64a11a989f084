"""New motion from a sentence, computed from what was learned."""
