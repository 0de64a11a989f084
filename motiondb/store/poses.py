"""Poses as they are stored: packed, and the same bit by bit when they are unpacked.

A number of a pose changes slowly from frame to frame. Where all are multiples of ``POSE_STEP``, as
those of captures are, each is that integer; else the 32 bits of each float are read as one. Each
column of integers is replaced by its second differences in time (modulo 2^32), and these are turned
so that small ones, of either sign, have leading zeros. Then the first bytes of all numbers stand
together, then the second ones, and so on, and zlib packs them. Measured on an hour of CMU captures:
8 MB of multiples, 15 MB of floats; the floats take 38, and 34 in DuckDB's own compression.
"""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray

from motiondb.records import POSE_STEP, Float32Array

POSE_SIZE = 87  # Numbers of a pose: root position x y z, then 21 quaternions w x y z
_MULTIPLES = b"\1"  # First byte where integers are multiples; zlib begins with another one
_MOST = 2**31 - 1  # Largest integer that is kept


def pack_poses(poses: Float32Array) -> bytes:
    """Pack poses (frames, 87)."""
    columns = np.ascontiguousarray(poses.T, dtype="<f4")
    numbers, first = columns.view("<i4"), b""
    multiples = np.rint(columns.astype(np.float64) / POSE_STEP)
    if (np.abs(multiples) <= _MOST).all():  # no number that is not finite, too
        whole = multiples.astype("<i4")
        if np.array_equal(_of_multiples(whole).view("<i4"), numbers):
            numbers, first = whole, _MULTIPLES
    for _ in range(2):
        numbers = np.diff(numbers, axis=1, prepend=np.zeros((len(numbers), 1), "<i4"))
    turned = (numbers << 1) ^ (numbers >> 31)
    planes = turned.reshape(-1).view(np.uint8).reshape(-1, 4).T
    return first + zlib.compress(np.ascontiguousarray(planes).tobytes())


def _of_multiples(whole: NDArray[np.int32]) -> NDArray[np.float32]:
    """The numbers that are multiples of the step."""
    return (whole * POSE_STEP).astype("<f4")


def unpack_poses(packed: bytes) -> Float32Array:
    """Unpack poses (frames, 87); ValueError or zlib.error where the bytes are not packed poses.

    >>> poses = np.linspace(-1, 1, 3 * POSE_SIZE, dtype=np.float32).reshape(3, POSE_SIZE)
    >>> bool((unpack_poses(pack_poses(poses)) == poses).all())
    True
    """
    are_multiples = packed[:1] == _MULTIPLES
    planes = np.frombuffer(zlib.decompress(packed[are_multiples:]), np.uint8).reshape(4, -1)
    turned = np.ascontiguousarray(planes.T).view("<u4").reshape(POSE_SIZE, -1)
    numbers = ((turned >> 1) ^ -(turned & 1).astype("<i4").view("<u4")).view("<i4")
    for _ in range(2):
        numbers = np.cumsum(numbers, axis=1, dtype="<i4")
    columns = _of_multiples(numbers) if are_multiples else numbers.view("<f4")
    return np.ascontiguousarray(columns.T).astype(np.float32, copy=False)
