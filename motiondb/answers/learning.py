"""What a database learned, in numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from motiondb.learn.learned_model import LearnedModel


@dataclass(frozen=True)
class LearnedSummary:
    """The size of what was learned."""

    captures: int
    segments: int
    symbols: int
    clusters: int
    dimensions: int
    words: int
    run: int


@dataclass(frozen=True, kw_only=True)
class LearnResult(LearnedSummary):
    """The result of a job that learns."""

    kind: Literal["learn"] = "learn"


def learned_summary(model: LearnedModel) -> LearnedSummary:
    """Return the size of what was learned.

    Parameters
    ----------
    model : LearnedModel
        What :meth:`MotionDB.learn` gives.
    """
    return LearnedSummary(
        len(set(model.segments.capture_ids.tolist())),
        len(model.segments.symbols),
        model.symbols.n_symbols,
        len(model.space.weights),
        model.space.coordinates.shape[1],
        len(model.association.words),
        model.run_id,
    )
