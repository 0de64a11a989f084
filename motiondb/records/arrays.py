"""Types of arrays, and the frame rate of motions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

MOTION_FPS = 30.0  # Frames per second of every canonical :class:`~motiondb.records.motion.Motion`
