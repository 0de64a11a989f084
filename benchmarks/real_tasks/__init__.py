"""Questions to real captures, and what people saw."""
