"""What the attack tries: odd files and texts, kills, damage, many at once, large questions."""
