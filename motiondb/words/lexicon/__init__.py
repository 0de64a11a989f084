"""From captions and questions to words: lemmas, synonyms and the vocabulary."""
