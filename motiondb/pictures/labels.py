"""Placement of the labels of crowded points without overlaps.

Labels are placed one after the other, those with the fewest neighbours first. Each is placed at the
first free position on rings around its point, nearest ring first; if none is free, at the position
of least overlap. All lengths are in pixels.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray

# Radii of the rings, in units of the gap, and angles, the most readable first. Both by hand.
_RINGS = (1.0, 1.8, 2.8, 4.0, 5.5, 7.5)
_ANGLES = np.deg2rad([0, 90, 270, 180, 45, 315, 135, 225, 20, 340, 160, 200, 65, 295, 115, 245])


def place_labels(
    points: FloatArray, sizes: FloatArray, gap: float, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Centres of labels: array (labels, 2), pixels.

    Shapes: `points`, `sizes` (labels, 2); `low`, `high` (2,).
    """
    crowd = np.sum(_distances(points) < 12.0 * gap, axis=1)
    discs = np.concatenate([points - gap, points + gap], axis=1)
    taken = discs
    middles = np.array(points, dtype=float)
    for label in np.argsort(crowd, kind="stable"):
        places = _places(points[label], sizes[label], gap)
        boxes = np.concatenate([places - sizes[label] / 2, places + sizes[label] / 2], axis=1)
        away = np.maximum(low - boxes[:, :2], 0).sum(1) + np.maximum(boxes[:, 2:] - high, 0).sum(1)
        cost = _overlaps(boxes, taken) + 1e3 * away
        best = int(np.argmin(cost > 0.0)) if (cost <= 0.0).any() else int(np.argmin(cost))
        middles[label] = places[best]
        taken = np.concatenate([taken, boxes[best : best + 1]])
    return middles


def _places(point: FloatArray, size: FloatArray, gap: float) -> FloatArray:
    """Possible centres of a label around its point, nearest ring first."""
    turns = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
    reach = 1.2 * gap + size / 2.0
    rings = [turns * (reach + (ring - 1.0) * 2.0 * gap) for ring in _RINGS]
    return point + np.concatenate(rings)


def _overlaps(boxes: FloatArray, taken: FloatArray) -> FloatArray:
    """Area of every box (n, 4) that boxes (m, 4) cover, pixels squared."""
    low = np.maximum(boxes[:, None, :2], taken[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], taken[None, :, 2:])
    return np.prod(np.maximum(high - low, 0.0), axis=2).sum(axis=1)


def _distances(points: FloatArray) -> FloatArray:
    return np.linalg.norm(points[:, None] - points[None], axis=2)
