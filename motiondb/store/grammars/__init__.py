"""The tables of grammars, of sequences derived from them, and of scenes."""
