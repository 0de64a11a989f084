"""Commands that bring captures, captions and events in and out, and keep the file in order."""
