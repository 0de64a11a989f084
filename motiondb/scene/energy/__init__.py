"""The energy of a scene, compiled, and where strings of clips begin."""
