"""Poses as they are stored: packed, and the same bit by bit when they are unpacked.

A number of a pose changes slowly from frame to frame. Where all are multiples of ``POSE_STEP``, as
those of captures are, each is that integer; else the 32 bits of each float are read as one. Each
column of integers is replaced by its second differences in time (modulo 2^32). Of multiples, w of a
quaternion is replaced by 2 (|w| - e) + (w < 0), e = sqrt(1 - x^2 - y^2 - z^2) rounded: mostly 0 or
1. All are turned so that small ones, of either sign, have leading zeros. Then the first bytes of
all numbers stand together, then the second ones, and so on, and zlib packs them, looking for runs
only: its search for other repetitions took three times as long and found none. Measured on an hour
of CMU captures: 6.9 MB of multiples (9.1 with w as it is), 15 MB of floats; the floats take 38, and
34 in DuckDB's own compression.
"""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray

from motiondb.records import POSE_STEP, Float32Array

POSE_SIZE = 87  # Numbers of a pose: root position x y z, then 21 quaternions w x y z
_W = np.arange(3, POSE_SIZE, 4)  # Columns of w
_OTHERS = np.delete(np.arange(POSE_SIZE), _W)
_MULTIPLES, _IMPLIED = b"\1", b"\2"  # First byte where integers are multiples; zlib has others
_ONE = round(1.0 / POSE_STEP)
_MOST = 2**31 - 1  # Largest integer that is kept


def pack_poses(poses: Float32Array) -> bytes:
    """Pack poses (frames, 87)."""
    columns = np.ascontiguousarray(poses.T, dtype="<f4")
    numbers, first = columns.view("<i4"), b""
    multiples = np.rint(columns.astype(np.float64) / POSE_STEP)
    signs = np.zeros((0, len(poses)), "<i4")
    # no number that is not finite, too
    if (np.abs(multiples) <= _MOST).all() and (np.abs(multiples[3:]) <= 8 * _ONE).all():
        whole = multiples.astype("<i4")
        if np.array_equal(_of_multiples(whole).view("<i4"), numbers):
            numbers, first, w = whole[_OTHERS], _IMPLIED, whole[_W]
            signs = 2 * (np.abs(w) - _implied(numbers)) + (w < 0)
    for _ in range(2):
        numbers = np.diff(numbers, axis=1, prepend=np.zeros((len(numbers), 1), "<i4"))
    numbers = np.concatenate([numbers, signs])
    turned = (numbers << 1) ^ (numbers >> 31)
    planes = turned.reshape(-1).view(np.uint8).reshape(-1, 4).T
    packing = zlib.compressobj(strategy=zlib.Z_RLE)
    return first + packing.compress(np.ascontiguousarray(planes).tobytes()) + packing.flush()


def _implied(others: NDArray[np.int32]) -> NDArray[np.int32]:
    """|w| of unit quaternions (21, frames) from the other columns (66, frames), in steps."""
    v = others[3:].reshape(len(_W), 3, -1).astype(np.int64)
    left = np.maximum(_ONE**2 - (v * v).sum(axis=1), 0)
    return np.rint(np.sqrt(left.astype(np.float64))).astype("<i4")


def _of_multiples(whole: NDArray[np.int32]) -> NDArray[np.float32]:
    """The numbers that are multiples of the step."""
    return (whole * POSE_STEP).astype("<f4")


def unpack_poses(packed: bytes) -> Float32Array:
    """Unpack poses (frames, 87); ValueError or zlib.error where the bytes are not packed poses.

    >>> poses = np.linspace(-1, 1, 3 * POSE_SIZE, dtype=np.float32).reshape(3, POSE_SIZE)
    >>> bool((unpack_poses(pack_poses(poses)) == poses).all())
    True
    """
    kind = packed[:1] if packed[:1] in (_MULTIPLES, _IMPLIED) else b""
    planes = np.frombuffer(zlib.decompress(packed[len(kind) :]), np.uint8).reshape(4, -1)
    turned = np.ascontiguousarray(planes.T).view("<u4").reshape(POSE_SIZE, -1)
    numbers = ((turned >> 1) ^ -(turned & 1).astype("<i4").view("<u4")).view("<i4")
    n_moving = len(_OTHERS) if kind == _IMPLIED else POSE_SIZE
    numbers, signs = numbers[:n_moving], numbers[n_moving:]
    for _ in range(2):
        numbers = np.cumsum(numbers, axis=1, dtype="<i4")
    if kind == _IMPLIED:
        others, numbers = numbers, np.empty((POSE_SIZE, numbers.shape[1]), "<i4")
        w = (signs >> 1) + _implied(others)
        numbers[_OTHERS], numbers[_W] = others, np.where(signs & 1, -w, w)
    columns = _of_multiples(numbers) if kind else numbers.view("<f4")
    return np.ascontiguousarray(columns.T).astype(np.float32, copy=False)
