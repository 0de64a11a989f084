"""Rule sets and their description length."""
