"""Answers of :class:`motiondb.MotionDB` as dictionaries, ready for JSON."""
