"""Rule sets and their description length; where sentences repeat and agree."""
