"""The public operations: each loads from the store, computes with the pure packages, and saves.

========================  ===================================================================
``session``               the open store and the only cache, keyed by the store's revision
``learn``                 learn, drift; counts updated when captures and words change
``catalogue``             captures, words and events, in and out
``generate``              motion from a sentence, its files, generated captures that are kept
``ask``                   search, like, describe, facts and pictures
``grammars``, ``scenes``  the operations on grammars and scenes
``motion_db``             the class :class:`MotionDB`
========================  ===================================================================
"""

from motiondb.database.motion_db import MotionDB

__all__ = ["MotionDB"]
