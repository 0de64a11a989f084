"""Where in a take each word of its caption is shown."""
