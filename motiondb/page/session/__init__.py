"""What the server keeps while it runs: the open database, and what was made."""
