"""The learned model in shares, each with the rows of some captures alone.

What is large of a learned model has a row for each segment: scores, movement, and evidence of
words. A share has the rows of captures that follow one another. Together with all the rest it
tells of these captures what the whole model does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from motiondb.learn.learned import Learned, Prepared
from motiondb.learn.recognition import FeaturePool
from motiondb.records import Float32Array, IntArray

SMALL = ("likeness", "meanings")  # Arrays of ``prepare`` that all shares have, of all captures


class RowsFrom:
    """Rows of an array that follow one another; those before and behind them are elsewhere.

    `first`: Number of the first of them. `n`: Number of rows of the array.
    """

    def __init__(self, first: int, rows: NDArray[Any], n: int) -> None:
        self._first, self._rows = first, rows
        self.shape, self.size, self.dtype = (n, rows.shape[1]), n * rows.shape[1], rows.dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, which: slice | IntArray) -> NDArray[Any]:
        if isinstance(which, slice):
            least, behind, _ = which.indices(len(self))
        else:
            least, behind = (int(which.min()), int(which.max()) + 1) if len(which) else (0, 0)
        if behind <= least:
            return self._rows[:0]
        if not self._first <= least < behind <= self._first + len(self._rows):
            raise IndexError(f"rows {least} to {behind}: expected rows of this share, found others")
        if isinstance(which, slice):
            return self._rows[least - self._first : behind - self._first]
        return self._rows[which - self._first]


@dataclass(frozen=True, eq=False)
class Share:
    """The rows of captures that follow one another among those of a learned model."""

    captures: tuple[int, ...]  # Their numbers
    pool: FeaturePool  # Their features
    scores: Float32Array  # (segments, symbols)
    movement: Float32Array  # (segments, columns)
    # Those of ``prepare`` that have rows of segments, or are bounds of captures; none without words
    evidence: Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Rest:
    """What all shares of a learned model have in common."""

    learned: Learned  # Without the rows of segments
    evidence: Mapping[str, NDArray[Any]]  # The others of ``prepare``
    places: Mapping[str, NDArray[Any]]  # ``Prepared.places``


def divided(learned: Learned, n: int) -> list[tuple[int, ...]]:
    """All captures of a model in at most n runs, of about equal lengths of motion."""
    captures = list(learned.rows)
    frames = np.cumsum([learned.captures[capture].motion_frames for capture in captures])
    edges = np.searchsorted(frames, frames[-1] * np.arange(1, n) / n, side="right")
    return [tuple(run.tolist()) for run in np.split(np.array(captures), edges) if len(run)]


def rest_of(learned: Learned) -> Rest:
    """What all shares of a model that is ready for questions have in common."""
    assert learned.prepared is not None
    prepared, table = learned.prepared, learned.segments
    evidence = {name: prepared.evidence[name] for name in SMALL if name in prepared.evidence}
    bare = replace(table, scores=table.scores[:0], movement=table.movement[:0])
    return Rest(replace(learned, segments=bare, prepared=None), evidence, prepared.places)


def share_of(learned: Learned, pool: FeaturePool, captures: Sequence[int]) -> Share:
    """The share of a model that is ready for questions, of captures that follow one another."""
    assert learned.prepared is not None
    rows, of_all = segments_of(learned, captures), learned.prepared.evidence
    before = learned.places_in_rows[captures[0]]
    behind, evidence = before + len(captures), dict[str, NDArray[Any]]()
    if of_all:  # of the odds, each capture has a row more than segments
        evidence["odds"] = of_all["odds"][rows.start + before : rows.stop + behind]
        evidence["extremes"] = of_all["extremes"][:, before:behind]
    return Share(
        tuple(captures),
        pool.only(set(captures)),
        learned.segments.scores[rows],
        learned.segments.movement[rows],
        evidence,
    )


def joined(rest: Rest, share: Share) -> Learned:
    """The model with the rows of a share; IndexError where those of other captures are needed."""
    first, table = segments_of(rest.learned, share.captures).start, rest.learned.segments
    scores, movement = (
        cast(Float32Array, RowsFrom(first, rows, len(table.starts)))
        for rows in (share.scores, share.movement)
    )
    learned = replace(rest.learned, segments=replace(table, scores=scores, movement=movement))
    evidence = {**rest.evidence, **share.evidence}
    return replace(learned, prepared=Prepared(learned, evidence, rest.places, share.captures))


def segments_of(learned: Learned, captures: Sequence[int]) -> slice:
    """The rows of the segment table of captures that follow one another."""
    return slice(learned.rows[captures[0]].start, learned.rows[captures[-1]].stop)
