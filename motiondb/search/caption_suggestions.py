"""Which captures to caption next; see :mod:`motiondb.search.suggestion`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.learn.learned import Learned
from motiondb.meaning import counting
from motiondb.meaning.caption_evidence import whole_vectors
from motiondb.search import suggestion


@dataclass(frozen=True)
class CaptionSuggestion:
    """A capture without words that should be captioned next."""

    rank: int  # 1 for the first
    capture: str  # Name of the capture
    seconds: float  # Length of the capture
    # Share of the uncertainty about captures without words that its words would remove, 0 to 1
    gain: float
    # Names of captures without words that its words would also describe, most similar first
    like: tuple[str, ...]
    symbols: tuple[int, ...]  # Symbols of the capture that never occurred with words
    reason: str


def suggest_captions(learned: Learned, limit: int = 10) -> list[CaptionSuggestion]:
    """Captures without captions, the most informative about the others first.

    A capture counts as described when one motion word was written about any part of it.
    """
    described = list(learned.described)
    with_words = {d.capture_id for d in described}
    bare = [capture for capture in sorted(learned.rows) if capture not in with_words]
    if not bare:
        return []
    rows = {capture: learned.rows[capture] for capture in bare}
    vectors = whole_vectors(learned.standardised, learned.segments, rows)
    number = {word: n for n, word in enumerate({w for d in described for w in d.words})}
    known = np.zeros((0, vectors.shape[1]))
    if described:
        known = counting.training_rows(learned.segments, described, learned.score_space, number)[0]
    chosen = suggestion.suggest(vectors, known, limit)
    return [_explained(learned, bare, rank, one) for rank, one in enumerate(chosen, start=1)]


def _explained(
    learned: Learned, bare: list[int], rank: int, one: suggestion.Suggestion
) -> CaptionSuggestion:
    capture = bare[one.index]
    info = learned.captures[capture]
    others = [bare[n] for n in one.served]
    names = tuple(learned.captures[c].name for c in others)
    seen = learned.association.translation[1:].sum(axis=1) > 0
    mine = np.unique(learned.segments.symbols[learned.rows[capture]])
    silent = tuple(int(s) for s in mine if not seen[s])
    reason = f"{one.known:.0%} known from other words"
    if names:
        seconds = sum(learned.captures[c].duration for c in others)
        shown = ", ".join(names[:2]) + (", ..." if len(names) > 2 else "")
        reason += f"; similar to {len(names)} more ({seconds:.0f} s: {shown})"
    if silent:
        which = "symbol" if len(silent) == 1 else "symbols"
        reason += f"; {which} {', '.join(map(str, silent))} never occurred with words"
    return CaptionSuggestion(
        rank, info.name, info.duration, round(one.gain, 6), names, silent, reason
    )
