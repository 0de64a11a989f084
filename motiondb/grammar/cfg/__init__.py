"""Context-free grammars: records, compiled form, chart, parse, prefix and length probabilities."""
