"""Evidence of words in motion: maps, places, the judge, and calibrated probabilities."""
