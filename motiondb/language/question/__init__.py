"""A question: its tree, its readings for a search, its plain actions."""
