"""Growth of time, memory and size with the hours of motion."""
