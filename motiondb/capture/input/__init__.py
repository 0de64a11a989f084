"""Text, units and limits of files, before any format is known."""
