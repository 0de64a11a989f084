"""Motion in the form that the player draws: a figure of capsules, packed as bytes."""
