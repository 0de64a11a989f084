"""Statistical translation between symbols and words: association, transitions and decoding."""
