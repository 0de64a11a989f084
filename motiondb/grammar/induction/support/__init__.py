"""Evaluation of rules by sentences: cheapest parses, refitted rules, evidence for loops."""
