"""What a capture lacks: things it needs, faults, wrong units and rates."""
