"""A small writer of C3D, for every machine and with whatever a test wants to be said wrongly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

BLOCK = 512
PC, DEC, SGI = 84, 85, 86
Value = str | int | float | Sequence[str] | Sequence[int] | Sequence[float] | None


def c3d_bytes(
    points: np.ndarray,
    labels: Sequence[str],
    *,
    machine: int = PC,
    scale: float = -1.0,
    analog: int = 0,
    said: Mapping[str, Value] | None = None,
    header: Mapping[int, int] | None = None,
    rate: float = 100.0,
) -> bytes:
    """Write places (frames, points, 3), NaN where lost, in file units.

    `scale`: negative for floats. `analog`: samples behind the points of each frame. `said`:
    parameters by "GROUP:NAME" that replace the usual ones, None for none. `header`: words by their
    number (from 1) that replace the usual ones. `rate`: that of the header.
    """
    n_frames, n_points = points.shape[:2]
    parameters: dict[str, Value] = {
        "POINT:USED": n_points,
        "POINT:SCALE": float(scale),
        "POINT:RATE": float(rate),
        "POINT:DATA_START": 0,
        "POINT:FRAMES": min(n_frames, 65535),
        "POINT:UNITS": "mm",
    }
    for place in range(0, n_points, 255):
        name = "POINT:LABELS" + (str(place // 255 + 1) if place else "")
        parameters[name] = list(labels[place : place + 255])
    channels = [f"A{number}" for number in range(analog)]
    parameters |= {"ANALOG:USED": analog, "ANALOG:RATE": float(rate), "ANALOG:LABELS": channels}
    parameters |= {"ANALOG:GEN_SCALE": 1.0, "ANALOG:SCALE": [1.0] * analog}
    parameters |= {"ANALOG:OFFSET": [0] * analog, "ANALOG:UNITS": ["V"] * analog, **(said or {})}
    stated = {name: value for name, value in parameters.items() if value is not None}
    written = _section(stated, machine)
    start = 2 + len(written) // BLOCK
    if stated.get("POINT:DATA_START") == 0:
        written = _section(stated | {"POINT:DATA_START": start}, machine)
    words = {1: 0x5002 if machine != SGI else 0x0250, 2: n_points, 3: analog, 4: 1}
    words |= {5: min(n_frames, 65535), 9: start, 10: 1, **(header or {})}
    floats = _floats([scale, rate], machine)
    halves = [int(word) for word in np.frombuffer(floats, _order(machine) + "u2")]
    words = dict(zip((7, 8, 11, 12), halves)) | words
    head = np.zeros(256, _order(machine) + "u2")
    for number, word in words.items():
        head[number - 1] = word
    values = np.zeros((n_frames, 4 * n_points + analog))
    is_lost = np.isnan(points).any(axis=2)
    places = np.where(is_lost[..., None], 0.0, points) / (scale if scale > 0 else 1.0)
    residuals = np.where(is_lost, -1.0, 0.0)[..., None]
    values[:, : 4 * n_points] = np.concatenate([places, residuals], axis=2).reshape(
        n_frames, 4 * n_points
    )
    data = _floats(values, machine) if scale < 0 else _words(np.rint(values), machine)
    return head.tobytes() + written + _filled(data)


def _section(parameters: Mapping[str, Value], machine: int) -> bytes:
    """Write the groups and parameters with their header."""
    groups = list(dict.fromkeys(name.split(":")[0] for name in parameters))
    body = b"".join(
        bytes([len(group), 256 - 1 - number]) + group.encode() + _words([3], machine) + b"\0"
        for number, group in enumerate(groups)
    )
    for full, value in parameters.items():
        group, name = full.split(":")
        record = _record(value, machine) + b"\0"
        body += bytes([len(name), 1 + groups.index(group)]) + name.encode()
        body += _words([2 + len(record)], machine) + record
    body += b"\0\0"
    return _filled(bytes([1, 0x50, -(-(len(body) + 4) // BLOCK), machine]) + body)


def _record(value: Value, machine: int) -> bytes:
    """Write type, sizes and values."""
    if isinstance(value, str):
        return bytes([255, 1, len(value)]) + value.encode()
    if isinstance(value, int):
        return bytes([2, 0]) + _words([value], machine)
    if isinstance(value, float):
        return bytes([4, 0]) + _floats([value], machine)
    values = list(value or ())
    if values and isinstance(values[0], str):
        longest = max(len(str(text).encode()) for text in values)
        text = b"".join(str(text).encode().ljust(longest) for text in values)
        return bytes([255, 2, longest, len(values)]) + text
    if values and isinstance(values[0], float):
        return bytes([4, 1, len(values)]) + _floats(values, machine)
    return bytes([2, 1, len(values)]) + _words(values, machine)


def _order(machine: int) -> str:
    return ">" if machine == SGI else "<"


def _words(values: object, machine: int) -> bytes:
    return np.asarray(values).astype("i8").astype(_order(machine) + "i2").tobytes()


def _floats(values: object, machine: int) -> bytes:
    """Floats of a machine; those of DEC are four times as large, with their words exchanged."""
    numbers = np.asarray(values, float)
    if machine != DEC:
        return numbers.astype(_order(machine) + "f4").tobytes()
    return (
        np.ascontiguousarray((4.0 * numbers).astype("<f4"))
        .view("<u2")
        .reshape(-1, 2)[:, ::-1]
        .tobytes()
    )


def _filled(data: bytes) -> bytes:
    """Fill up the last block with zeros."""
    return data + bytes(-len(data) % BLOCK)
