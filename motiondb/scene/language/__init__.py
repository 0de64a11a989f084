"""Motion grammars and tactics diagrams: text files, records, and what they ask of players."""
