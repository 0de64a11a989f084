"""How sure answers and places are, learned from questions with known answers."""
