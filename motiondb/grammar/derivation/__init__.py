"""New and changed sentences of a grammar: drawn, listed, planned, edited."""
