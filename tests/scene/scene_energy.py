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
    """-log P(Y) of a scene and its parts, each divided by its weight."""

    total: float
    rules: FloatArray
    smooth: float
    collision: float
    effort: float
    by_token: tuple[FloatArray, ...]  # of every player the errors of their clips: 1 and shares
    overlaps: NDArray[np.int64]  # points of the grid at which two touch


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
