"""Migrations: changes of the tables, in order."""
