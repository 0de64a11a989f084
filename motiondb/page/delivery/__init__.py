"""The motion and the files that are sent for a ref."""
