"""Maps from motion to words, for whole takes and for places inside takes."""
