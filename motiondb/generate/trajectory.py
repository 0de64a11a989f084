"""The most probable smooth trajectory of a joined HMM.

Notation: c (frames, D) the static values sought; W stacks them with their time differences

    delta c_t = (c_{t+1} - c_{t-1}) / 2,    delta^2 c_t = c_{t+1} - 2 c_t + c_{t-1}

(ends repeated); mu and U the means and variances of all three along the state sequence. The most
probable c solves W' U^-1 W c = W' U^-1 mu, a banded system for each dimension. Its variance is too
small; ``widen`` raises the variance of each dimension towards that of the states.

Source: Tokuda et al., Speech parameter generation algorithms for HMM-based speech synthesis (2000);
Toda and Tokuda (2007) for the global variance.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray


def with_deltas(values: FloatArray) -> FloatArray:
    """Append first and second differences: array (frames, 3 D), from `values` (frames, D)."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    delta = (padded[2:] - padded[:-2]) / 2.0
    delta2 = padded[2:] - 2.0 * padded[1:-1] + padded[:-2]
    return np.concatenate([values, delta, delta2], axis=1)


def most_probable(means: FloatArray, covars: FloatArray) -> FloatArray:
    """Most probable trajectory c: array (frames, D), from `means`, `covars` (frames, 3 D)."""
    from scipy.linalg import solveh_banded

    n_frames, n_dims = len(means), means.shape[1] // 3
    result = np.empty((n_frames, n_dims))
    for d in range(n_dims):
        columns = [d, d + n_dims, d + 2 * n_dims]
        band, right = _normal_equations(means[:, columns], 1.0 / covars[:, columns])
        result[:, d] = solveh_banded(band, right, lower=True)
    return result


def _normal_equations(mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower band (3, frames) of W' P W and the vector W' P mu for one dimension."""
    n = len(mean)
    band = np.zeros((3, n))
    right = np.zeros(n)
    windows = (((0, 1.0),), ((-1, -0.5), (1, 0.5)), ((-1, 1.0), (0, -2.0), (1, 1.0)))
    time = np.arange(n)
    for w, window in enumerate(windows):
        weighted = precision[:, w]
        for step, factor in window:
            column = np.clip(time + step, 0, n - 1)
            np.add.at(right, column, factor * weighted * mean[:, w])
            for other_step, other in window:
                row = np.clip(time + other_step, 0, n - 1)
                lag = row - column
                keep = lag >= 0
                np.add.at(band, (lag[keep], column[keep]), (factor * other * weighted)[keep])
    return band, right


def widen(
    trajectory: FloatArray, means: FloatArray, covars: FloatArray, strength: float = 0.8
) -> FloatArray:
    """Scale every dimension about its mean towards the variance of the states.

    The factor is between 1 and 1.6; this bound and the default strength were chosen by hand.

    Shapes: `trajectory`, `means`, `covars` (frames, D).
    """
    centre = trajectory.mean(axis=0)
    wanted = means.var(axis=0) + covars.mean(axis=0)
    variance = np.maximum(trajectory.var(axis=0), 1e-12)
    factor = np.clip(np.sqrt(wanted / variance), 1.0, 1.6)
    return centre + (trajectory - centre) * (1.0 + strength * (factor - 1.0))
