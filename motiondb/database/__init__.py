"""The verbs, each: load from the store, compute with the pure rooms, save.

========================  ===================================================================
``session``               the open store and the only cache, keyed by the store's revision
``learn``                 learn, drift; counts kept true while captures and words change
``catalogue``             captures, words and events, in and out
``generate``              motion from a sentence, its files, generated captures that are kept
``ask``                   search, like, describe, facts and pictures
``grammars``, ``scenes``  the verbs of grammars and of scenes
``motion_db``             the class :class:`MotionDB`
========================  ===================================================================
"""

from motiondb.database.motion_db import MotionDB

__all__ = ["MotionDB"]
