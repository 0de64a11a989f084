"""The page: a local server for the browser, over the same class as the command line.

Every route translates a request to a call of :class:`motiondb.MotionDB` and its answer to JSON, or
to a compact binary form of motions (:mod:`motiondb.page.motion`). Nothing is computed
here.
"""
