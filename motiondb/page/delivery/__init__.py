"""What is sent for a ref: its motion, its files."""
