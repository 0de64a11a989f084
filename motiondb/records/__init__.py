"""The frozen records that the stages hand to one another.

World frame everywhere: right-handed, y up, metres, seconds. Rotations are unit quaternions
(w, x, y, z). Frame intervals are half-open, [start, end). ``parents`` holds -1 for the root and
every parent comes before its children.
"""

from motiondb.records.arrays import MOTION_FPS, BoolArray, Float32Array, FloatArray, IntArray
from motiondb.records.catalogue import (
    Caption,
    CaptureInfo,
    Event,
    Match,
    MatchPart,
    Relation,
    Run,
)
from motiondb.records.learned import (
    Association,
    MotionSymbols,
    Segment,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)
from motiondb.records.motion import (
    Clip,
    Motion,
    Skeleton,
)

__all__ = [
    "MOTION_FPS",
    "Association",
    "BoolArray",
    "Caption",
    "CaptureInfo",
    "Clip",
    "Event",
    "Float32Array",
    "FloatArray",
    "IntArray",
    "Match",
    "MatchPart",
    "Motion",
    "MotionSymbols",
    "Relation",
    "Run",
    "Segment",
    "SegmentTable",
    "Skeleton",
    "StoredLearning",
    "SymbolSpace",
]
