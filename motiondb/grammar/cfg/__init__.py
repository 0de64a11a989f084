"""Context-free grammars: records, compiled form, the engine, parse, prefixes and lengths."""
