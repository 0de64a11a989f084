"""From sentences to rules: a search for the rule set of the shortest description."""
