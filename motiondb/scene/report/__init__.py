"""The report of a polished scene: rules, collisions, feet, speeds, and visible faults."""
