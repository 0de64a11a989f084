"""Tables of grammars, of the derivations of generated captures, and of scenes."""
