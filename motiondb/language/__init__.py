"""Words: lemmas, vocabulary, questions, translation between symbols and words; no motion."""
