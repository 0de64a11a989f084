"""C3D files of a person in T-pose, whole, and damaged from a seed."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from c3d_writer import BLOCK, c3d_bytes

_SIDES = {
    "ASI": (12, 100, 10), "PSI": (5, 100, -10), "KNE": (15, 50, 0), "ANK": (14, 8, 0),
    "TOE": (10, 3, 14), "SHO": (18, 150, 0), "ELB": (45, 145, 0), "WRA": (70, 145, 3),
    "WRB": (70, 145, -3), "FHD": (7, 170, 10), "BHD": (7, 170, -10),
}  # fmt: skip
MARKERS: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {f"L{name}": place for name, place in _SIDES.items()}
    | {f"R{name}": (-x, y, z) for name, (x, y, z) in _SIDES.items()}
    | {"C7": (0, 150, -7), "CLAV": (0, 145, 9), "STRN": (0, 125, 12), "T10": (0, 125, -10)}
)
"""Places of the markers of Plug-in Gait on a person in T-pose, centimetres, y up."""
ODD_FLOATS = (np.nan, np.inf, -np.inf, 1e30, -1e30, 1e-40, 0.0, -1.0, 3.4e38)
ODD_WORDS = (0, 1, 2, 255, 256, 0x5002, 0x7FFF, 0x8000, 0xFFFF)


def whole_c3d(n_frames: int = 12, labels: Sequence[str] = tuple(MARKERS)) -> bytes:
    """Write a person who slides ahead by 1 cm a frame at 100 frames a second, millimetres, z up."""
    places = 10.0 * np.array(list(MARKERS.values()))[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    ahead = np.arange(n_frames)[:, None, None] * [0.0, -10.0, 0.0]
    return c3d_bytes(places + ahead, labels)


def damaged_c3d(rng: np.random.Generator) -> bytes:
    """Write a file and damage it in up to four places; some damage leaves it readable."""
    data = bytearray(whole_c3d(int(rng.integers(2, 30)), _labels(rng)))
    parts = {"header": (0, 24), "parameters": (BLOCK, 3 * BLOCK), "data": (3 * BLOCK, len(data))}
    for _ in range(int(rng.integers(0, 5))):
        start, end = parts[str(rng.choice(list(parts), p=[0.2, 0.3, 0.5]))]
        place = int(rng.integers(start, min(end, len(data)) - 4))
        how = int(rng.integers(5))
        if how == 0:
            data[place] ^= 1 << int(rng.integers(8))
        elif how == 1:
            data[place : place + 2] = struct.pack("<H", int(rng.choice(ODD_WORDS)))
        elif how == 2:
            place -= place % 4
            data[place : place + 4] = struct.pack("<f", float(rng.choice(ODD_FLOATS)))
        elif how == 3:
            data[place : place + 4] = rng.bytes(4)
        elif rng.random() < 0.2:
            del data[place:]
            data += bytes(4 * BLOCK - len(data)) if len(data) < 4 * BLOCK else b""
    return bytes(data)


def _labels(rng: np.random.Generator) -> tuple[str, ...]:
    """Draw names of the markers: mostly whole, some with one that is odd."""
    names = list(MARKERS)
    if rng.random() < 0.3:
        odd = ("", "LASI", "Ben:LASI", "\x00\x01", "A:B:C", "*110", "lknee", "\xff" * 6)
        names[int(rng.integers(len(names)))] = str(rng.choice(odd))
    prefix = str(rng.choice(["", "Anna:"]))
    return tuple(prefix + name for name in names)
