"""Markov chain Monte Carlo over scenes."""
