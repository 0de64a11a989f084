"""Commands that import and export captures, captions and events, and maintain the file."""
