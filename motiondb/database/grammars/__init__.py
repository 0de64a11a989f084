"""The verbs of motion grammars."""
