"""From strings of long takes to sentences: repeats, cuts, and their description length."""
