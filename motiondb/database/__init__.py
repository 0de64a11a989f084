"""The database as its users know it: one class, a verb a method.

The modules beside it load from the store, compute with the pure stages, and save:
``cataloguing`` (add), ``learning`` (learn), ``answering`` (search, like, describe) and
``generating`` (generate, export).
"""

from motiondb.database.motion_db import MotionDB

__all__ = ["MotionDB"]
