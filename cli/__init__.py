"""The command line: thin commands over :class:`motiondb.database.MotionDB`."""
