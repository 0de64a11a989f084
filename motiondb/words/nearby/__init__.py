"""Known words that replace a word that is in no caption: a table built from WordNet."""
