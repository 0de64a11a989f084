"""What a word may be taken as where no caption holds it: a table built from WordNet."""
