"""The tables of the database (``schema.sql``) and their migrations."""
