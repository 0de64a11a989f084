"""The report of a polished scene: rules, collisions, feet, speeds, and what a viewer sees."""
