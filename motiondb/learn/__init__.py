"""What `learn` derives from a catalogue, as one frozen record."""
