"""-log P(Y) of a scene with its parts, which tests compare with slow twins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.energy import scene_arrays, token_errors
from motiondb.scene.energy.placement import ClipArrays
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.semantic_rules import Weights


@dataclass(frozen=True, eq=False)
class Energy:
    """-log P(Y) of a scene and its parts, each divided by its weight.

    Attributes
    ----------
    total : float
        The sum of all parts.
    rules : array (rules,)
        f_k / c_k of every row of the table.
    smooth : float
        The part of the seams.
    collision : float
        The part of collisions.
    effort : float
        The part of the distance travelled.
    by_token : tuple of array (clips,)
        For every player the errors of their clips: 1 and their shares.
    overlaps : array of int (players, players)
        Number of grid points at which two touch.
    """

    total: float
    rules: FloatArray
    smooth: float
    collision: float
    effort: float
    by_token: tuple[FloatArray, ...]
    overlaps: NDArray[np.int64]


def energy(
    state: SceneState, library: ClipArrays, table: RuleTable, weights: Weights, every: int = 1
) -> Energy:
    """Return -log P(Y) of a scene, evaluated at every ``every``-th frame."""
    scene = scene_arrays(state, library, table, weights, every)
    errors = np.zeros(scene.entry.shape)
    token_errors(scene, library, errors)
    total, _, smooth, collision, effort = scene.total.tolist()
    by_token = tuple(row[:n] for row, n in zip(errors, scene.n_clips, strict=True))
    return Energy(total, scene.cost, smooth, collision, effort, by_token, scene.overlaps)
