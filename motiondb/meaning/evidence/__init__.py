"""Evidence for a question or an example in every capture."""
