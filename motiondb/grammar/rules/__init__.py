"""Rule sets and their description length; repeats and alignments of sentences."""
