"""What sentences support: cheapest parses, refitted rules, evidence for loops and contexts."""
