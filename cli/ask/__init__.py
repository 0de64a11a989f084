"""Commands search, like, describe and generate, and the printing of questions and reasons."""
