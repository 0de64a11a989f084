"""The object: its holder, its position, and the hands and heads that follow it."""
