"""The state of the server: the open database, and motions made while it runs."""
