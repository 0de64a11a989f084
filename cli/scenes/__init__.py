"""Commands of ``motiondb scene``: motion grammars, tactics diagrams and animated scenes."""
