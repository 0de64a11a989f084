"""Open the database file, share it with threads and processes, and change it in transactions."""
