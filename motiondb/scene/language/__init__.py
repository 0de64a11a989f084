"""Motion grammars and tactics diagrams: text files, records, and requirements of players."""
