"""f of semantic rules in plain NumPy, with which tests compare the compiled ones."""

from __future__ import annotations

import math

import numpy as np

from motiondb.scene.language.semantic_rules import PASS_SPEED, bearing, line_error

__all__ = ["bearing", "line_error"]


def position_error(position: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return f_pos, m, of places (..., 2) on the ground."""
    return np.asarray(np.linalg.norm(position - target, axis=-1))


def direction_error(heading: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return f_dir, radians in [0, pi]: the smallest turn from one heading to the other."""
    turn = np.mod(np.subtract(heading, wanted), 2.0 * math.pi)
    return np.asarray(np.minimum(turn, 2.0 * math.pi - turn))


def synchronisation_error(first: float, second: float, lag: float) -> np.ndarray:
    """Return f_synch, s: the deviation of the time from ``first`` to ``second`` from ``lag``."""
    return np.asarray(np.abs(np.subtract(second, first) - lag))


def distance_error(position: np.ndarray, target: np.ndarray, near: float, far: float) -> np.ndarray:
    """Return f_dist: 0 if the distance is in [near, far] metres, 1 elsewhere."""
    distance = position_error(position, target)
    return np.where((distance >= near) & (distance <= far), 0.0, 1.0)


def flight_time(thrown: np.ndarray, caught: np.ndarray) -> np.ndarray:
    """Return the seconds that a passed ball flies between places (..., 2), m."""
    return position_error(thrown, caught) / PASS_SPEED
