"""The judge of motion: its model, and its fitting and calibration."""
