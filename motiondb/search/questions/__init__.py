"""Search by words: scores of intervals under a question, and the reasons of the scores."""
