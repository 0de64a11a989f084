"""Probabilities of answers, fitted to answers that are known."""
