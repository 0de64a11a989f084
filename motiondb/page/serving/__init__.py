"""The server: start and address, who may ask, the application with all routes."""
