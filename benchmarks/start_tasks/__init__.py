"""Tasks of the benchmark of starts."""
