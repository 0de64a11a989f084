"""Drift: how far the captures have changed since the database learned, and whether to learn again.

Counts are updated with every change; the symbols, the vocabulary and the calibration are not. Three
shares measure whether this matters:

- strange motion: segments of captures that came later whose log-likelihood under the best symbol,
  nats per frame, is below that of 95 % of the motion learned from;
- new words: words in captions that are not in the vocabulary;
- turnover: motion that was added or removed since, relative to the motion learned from.

Measured on real captures, symbols learned without the performers or captures in question: 82 % of
break-dance is strange, 60 % of the motion of a dancer, 19 % of basketball, 8 % of further walks and
jumps of a known performer, 0 % of further walks of an unknown one.

Learning again is worthwhile if strange motion is more than ``STRANGE`` of all motion, new words
are more than ``NEW_WORDS`` of all words written, or the turnover is more than ``TURNOVER``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray, IntArray, SegmentTable

STRANGE = 0.1
"""Chosen by hand, from the shares measured on real captures: twice the shares for more captures of
the same kind."""
NEW_WORDS = 0.05
TURNOVER = 0.5
_WORST = 0.05  # Share of the motion learned from that counts as strange itself


@dataclass(frozen=True)
class Drift:
    """The changes since the database learned.

    Attributes
    ----------
    captures_added : int
        Captures added since it learned.
    captures_removed : int
        Captures removed since it learned.
    seconds_added : float
        Motion added.
    explained_less : float
        Mean log-likelihood of the motion learned from less that of the added motion, nats per
        frame.
    strange : float
        Share of the added motion that is strange; 0.05 for more of the same.
    below_background : float
        Share of the added motion that the background model explains better than any symbol.
    strange_of_all : float
        Strange motion as a share of all motion.
    new_words : float
        New words as a share of all words written.
    turnover : float
        Motion added or removed, relative to the motion learned from.
    words : tuple of str
        The new words, sorted.
    relearn : bool
        Whether learning again is worthwhile.
    reasons : tuple of str
        Why learning again is worthwhile.
    """

    captures_added: int
    captures_removed: int
    seconds_added: float
    explained_less: float
    strange: float
    below_background: float
    strange_of_all: float
    new_words: float
    turnover: float
    words: tuple[str, ...]
    relearn: bool
    reasons: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class DriftBaseline:
    """The motion learned from, as drift is measured against it."""

    captures: IntArray  # (captures,): numbers of the captures learned from
    mean: float  # Mean log-likelihood of the best symbol over frames, nats per frame
    # Log-likelihood below which the worst twentieth of the frames lies, nats per frame
    worst: float
    frames: float  # Number of frames learned from, 30 a second


def fit_baseline(table: SegmentTable) -> DriftBaseline:
    """The baseline that ``learn`` stores for drift."""
    explained, frames = table.log_likelihoods, _frames(table)
    order = np.argsort(explained)
    reached = np.cumsum(frames[order]) / max(frames.sum(), 1)
    worst = explained[order][min(int(np.searchsorted(reached, _WORST)), len(order) - 1)]
    mean = np.average(explained, weights=frames)
    return DriftBaseline(
        np.unique(table.capture_ids), float(mean), float(worst), float(frames.sum())
    )


@dataclass(frozen=True)
class WordUse:
    """Words written about captures."""

    total: int  # Number of words written
    unknown: Mapping[str, int]  # Word outside the vocabulary -> how often it was written


def count_word_use(
    texts: Mapping[str, int],
    vocabulary_words: Sequence[str],
    synonyms: Mapping[str, str],
    lemmas: Mapping[str, str] | None = None,
) -> WordUse:
    """Count the words of captions, and those that are not in the vocabulary.

    `texts`: What was written -> how often.
    """
    from motiondb.language import vocabulary  # answers with a drift do not need it

    written: Counter[str] = Counter()
    for text, times in texts.items():
        for word in vocabulary.words_of(text, synonyms, lemmas):
            written[word] += times
    known = set(vocabulary_words)
    unknown = {word: times for word, times in written.items() if word not in known}
    return WordUse(written.total(), unknown)


def measure_drift(table: SegmentTable, baseline: DriftBaseline, words: WordUse) -> Drift:
    """The drift since the database learned."""
    new = ~np.isin(table.capture_ids, baseline.captures)
    gone = ~np.isin(baseline.captures, table.capture_ids)
    explained, frames = table.log_likelihoods[new], _frames(table)[new]
    below = explained < table.backgrounds[new]
    total = max(float(frames.sum()), 1.0)
    strange = float(frames[explained < baseline.worst].sum())
    left = float(_frames(table)[~new].sum())
    before = baseline.frames
    shares = {
        "strange_of_all": strange / max(float(_frames(table).sum()), 1.0),
        "new_words": sum(words.unknown.values()) / max(words.total, 1),
        "turnover": float((frames.sum() + before - left) / max(before, 1.0)),
    }
    reasons = _reasons(shares, tuple(sorted(words.unknown)))
    less = float(baseline.mean - (explained @ frames) / total) if len(frames) else 0.0
    return Drift(
        captures_added=len(np.unique(table.capture_ids[new])),
        captures_removed=int(gone.sum()),
        seconds_added=float(frames.sum()) / MOTION_FPS,
        explained_less=less,
        strange=strange / total,
        below_background=float(frames[below].sum()) / total,
        **shares,
        words=tuple(sorted(words.unknown)),
        relearn=bool(reasons),
        reasons=reasons,
    )


def _reasons(shares: dict[str, float], words: tuple[str, ...]) -> tuple[str, ...]:
    shown = ", ".join(words[:3]) + (", ..." if len(words) > 3 else "")
    texts = (
        ("strange_of_all", STRANGE, "of all motion is unlike the symbols"),
        ("new_words", NEW_WORDS, f"of all words in captions are new ({shown})"),
        ("turnover", TURNOVER, "as much motion was added or removed as it learned from"),
    )
    return tuple(f"{shares[key]:.0%} {text}" for key, limit, text in texts if shares[key] > limit)


def _frames(table: SegmentTable) -> FloatArray:
    return (table.ends - table.starts).astype(np.float64)
