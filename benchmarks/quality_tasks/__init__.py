"""The tasks of the quality benchmark, one module each."""
