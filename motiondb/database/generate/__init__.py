"""Motion from a sentence, its files, and generated captures."""
