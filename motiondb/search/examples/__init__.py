"""Search by example: alignment, warping and the extent of an activity."""
