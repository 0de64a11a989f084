"""The server: start and address, access control, the application with all routes."""
