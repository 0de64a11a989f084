"""Smooth curves through points, used to draw and to interpret the moves of a diagram.

A centripetal Catmull-Rom spline passes through its points without loops between them. The points at
both ends are mirrored, so that the curve starts towards the second point and arrives from the last
point but one.

Source: P. J. Barry and R. N. Goldman, "A Recursive Evaluation Algorithm for a Class of Catmull-Rom
Splines", SIGGRAPH 1988.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray


def smooth_curve(points: FloatArray, per_part: int = 24) -> FloatArray:
    """Return the smooth curve through points.

    Consecutive points at the same place count once. A single point is returned unchanged.

    Shapes: `points` (points, 2), m; result ((points - 1) * per_part + 1, 2), m.

    `per_part`: Number of samples between two consecutive points. 24 leaves no visible corners in a
    picture; chosen by hand.

    >>> smooth_curve(np.array([[0.0, 0.0], [2.0, 0.0]]), 2).round(6).tolist()
    [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]
    """
    points = np.asarray(points, dtype=float)
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    points = points[np.concatenate([[True], apart])]
    if len(points) < 2:
        return points
    ends = [2.0 * points[:1] - points[1:2], points, 2.0 * points[-1:] - points[-2:-1]]
    extended = np.concatenate(ends)
    u = np.arange(per_part) / per_part
    parts = [_part(extended[i : i + 4], u) for i in range(len(points) - 1)]
    return np.concatenate([*parts, points[-1:]])


def _part(p: FloatArray, u: FloatArray) -> FloatArray:
    """Return the curve between the second and third of four points at fractions ``u``."""
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(p, axis=0), axis=1)))])
    t = (knots[1] + u * (knots[2] - knots[1]))[:, None]

    def between(a: FloatArray, b: FloatArray, i: int, j: int) -> FloatArray:
        return ((knots[j] - t) * a + (t - knots[i]) * b) / (knots[j] - knots[i])

    a1, a2, a3 = (between(p[i], p[i + 1], i, i + 1) for i in range(3))
    return between(between(a1, a2, 0, 2), between(a2, a3, 1, 3), 1, 2)


def path_fractions(points: FloatArray) -> FloatArray:
    """Return the position of each point along the curve, as a fraction of its length from 0 to 1.

    >>> path_fractions(np.array([[0.0, 0.0], [1.0, 0.0], [4.0, 0.0]])).round(3).tolist()
    [0.0, 0.25, 1.0]
    """
    points = np.asarray(points, dtype=float)
    moved = np.concatenate([[False], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9])
    per_part = 64  # samples for the length; chosen by hand
    steps = np.linalg.norm(np.diff(smooth_curve(points, per_part), axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps.reshape(-1, per_part).sum(axis=1))])
    return np.asarray(lengths[np.cumsum(moved)] / max(float(lengths[-1]), 1e-12))
