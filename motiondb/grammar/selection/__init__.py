"""The number of terminals, chosen by the bits of terminals, sentences and rules together."""
