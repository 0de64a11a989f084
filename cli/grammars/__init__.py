"""Commands of ``motiondb grammar``: grammars learned from captures."""
