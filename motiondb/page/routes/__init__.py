"""The routes; each calls :class:`motiondb.MotionDB`."""
