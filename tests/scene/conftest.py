"""A library of clips that wander at random: no captures are needed to place them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from motiondb.scene.clips.clips import ClipLibrary, ClipSource

Wandering = Callable[..., ClipLibrary]


def wandering_library(
    terminals: Sequence[str], *, each: int = 6, seed: int = 0, frames: tuple[int, int] = (7, 60)
) -> ClipLibrary:
    """``each`` clips of every terminal, their paths, instants and seams drawn at random."""
    rng = np.random.default_rng(seed)
    n = len(terminals) * each
    lengths = rng.integers(*frames, size=n)
    paths, steps = [], []
    for length in lengths:
        ahead = np.array([0.0, 0.04, 0.0]) + rng.normal(0.0, 0.02, 3)
        path = np.cumsum(rng.normal(ahead, 0.01, (length + 1, 3)), axis=0)
        paths.append(path[:-1] - path[0])
        steps.append(path[-1] - path[0])
    return ClipLibrary(
        terminals=tuple(terminals),
        terminal=np.repeat(np.arange(len(terminals)), each).astype(np.int32),
        first=(np.arange(len(terminals) + 1) * each).astype(np.int32),
        n_frames=lengths.astype(np.int32),
        step=np.array(steps),
        event_frame=np.where(rng.random(n) < 0.4, -1, lengths // 3).astype(np.int32),
        path_start=np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int32),
        path=np.concatenate(paths),
        seam=rng.random((9, 9)).astype(np.float32),
        seam_class=rng.integers(0, 9, n).astype(np.int32),
        hand=np.zeros((n, 3)),
        source=tuple(ClipSource(f"clip{k}", 0, int(length)) for k, length in enumerate(lengths)),
    )


@pytest.fixture(scope="session")
def wandering() -> Wandering:
    """Makes libraries: see :func:`wandering_library`."""
    return wandering_library
