"""How many symbols there are and which: first groups, competitive learning, description length."""
