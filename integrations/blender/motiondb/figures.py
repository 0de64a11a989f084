"""Small pictures of motions: stick figures at the begin, in the middle and at the end."""

from __future__ import annotations

import numpy as np

from .client import Array

SIZE = 128  # Pixels of a side
_COLOURS = ((0.45, 0.45, 0.5), (0.75, 0.6, 0.35), (1.0, 0.75, 0.2))  # Begin, middle, end
_MARGIN = 6


def draw(points: Array, parents: list[int]) -> Array:
    """Return pixels (SIZE, SIZE, 4), the lowest row first, of points (frames, points, 3), y up."""
    pixels = np.zeros((SIZE, SIZE, 4))
    if not len(points):
        return pixels
    shown = points[np.linspace(0, len(points) - 1, 3).round().astype(int)]
    # seen from the front and the side at once; each figure stands in its own third
    flat = np.stack([0.8 * shown[..., 0] + 0.6 * shown[..., 2], shown[..., 1]], axis=-1)
    flat[..., 0] -= flat[:, :1, 0]
    height = max(float(np.ptp(flat[..., 1])), 2.0 * float(np.abs(flat[..., 0]).max()), 0.5)
    scale = (SIZE - 2 * _MARGIN) / max(height, 1.6)
    for number, (figure, colour) in enumerate(zip(flat, _COLOURS)):
        middle = SIZE * (2 * number + 1) / 6
        at = (figure - [0.0, flat[..., 1].min()]) * scale + [middle, _MARGIN]
        for point, parent in enumerate(parents):
            if parent >= 0:
                _line(pixels, at[parent], at[point], colour)
    return pixels


def _line(pixels: Array, start: Array, end: Array, colour: tuple[float, float, float]) -> None:
    """Draw a line two pixels wide."""
    steps = int(np.abs(end - start).max()) * 2 + 2
    along = start + np.linspace(0.0, 1.0, steps)[:, None] * (end - start)
    for right, up in ((0, 0), (1, 0), (0, 1)):
        at = (along + np.array([right, up])).astype(int)
        at = at[((at >= 0) & (at < SIZE)).all(axis=1)]
        pixels[at[:, 1], at[:, 0]] = (*colour, 1.0)
