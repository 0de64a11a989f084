"""Drift: how far the captures have moved away from what was learned, and whether to learn again.

What is counted keeps itself up to date; the symbols, the vocabulary and the calibration stay as
they were learned. Three things tell that this hurts:

- strange motion: segments of captures that came later, explained (log-likelihood of the best
  symbol, nats per frame) worse than 95 % of the motion learned from;
- new words: words in captions that the vocabulary lacks;
- turnover: motion that came or went since, relative to the motion learned from.

Measured on real captures, symbols learned without performers or captures in question: 82 % of
break-dance is strange, 60 % of a dancer, 19 % of basketball, 8 % of further walks and jumps of a
performer who is known, 0 % of further walks of one who is not.

Learning again is worthwhile where strange motion is more than ``STRANGE`` of all motion, new words
are more than ``NEW_WORDS`` of all words written, or the turnover is more than ``TURNOVER``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS, FloatArray, SegmentTable
from motiondb.words import vocabulary

STRANGE = 0.1
NEW_WORDS = 0.05
TURNOVER = 0.5
_WORST = 0.05


@dataclass(frozen=True)
class Drift:
    """What changed since the database learned.

    Attributes
    ----------
    captures_added, captures_removed : since it learned. seconds_added : of motion.
    explained_less : by how much the added motion is explained worse than the motion learned from,
        nats per frame, mean over frames. strange : share of the added motion that is strange (0.05
        for more of the same). below_background : share of the added motion that the background
        model explains better than any symbol.
    strange_of_all, new_words, turnover : the shares that decide, see the module.
    words : the new words, sorted.
    relearn : whether learning again is worthwhile; ``reasons`` says why.
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


def baseline(table: SegmentTable) -> dict[str, FloatArray]:
    """What ``learn`` keeps to measure drift against: arrays by name."""
    explained, frames = table.log_likelihoods, _frames(table)
    order = np.argsort(explained)
    reached = np.cumsum(frames[order]) / max(frames.sum(), 1)
    worst = explained[order][min(int(np.searchsorted(reached, _WORST)), len(order) - 1)]
    mean = np.average(explained, weights=frames)
    return {
        "learned_from": np.unique(table.capture_ids).astype(np.float64),
        "drift_baseline": np.array([mean, worst, float(frames.sum())]),
    }


def measure(database: store.Store) -> Drift | None:
    """The drift since the database learned; None where it has not, or kept no baseline."""
    if not store.is_learned(database):
        return None
    arrays = store.load_parameters(database, "learned_from", "drift_baseline")
    if "drift_baseline" not in arrays:
        return None
    table = store.load_segments(database, scores=False)
    mean, worst, frames_before = arrays["drift_baseline"]
    new = ~np.isin(table.capture_ids, arrays["learned_from"])
    gone = ~np.isin(arrays["learned_from"], table.capture_ids)
    explained, frames = table.log_likelihoods[new], _frames(table)[new]
    below = explained < table.backgrounds[new]
    total = max(float(frames.sum()), 1.0)
    strange = float(frames[explained < worst].sum())
    left = float(_frames(table)[~new].sum())
    said, unknown = _words(database)
    shares = {
        "strange_of_all": strange / max(float(_frames(table).sum()), 1.0),
        "new_words": sum(unknown.values()) / max(said, 1),
        "turnover": float((frames.sum() + frames_before - left) / max(frames_before, 1.0)),
    }
    reasons = _reasons(shares, tuple(sorted(unknown)))
    return Drift(
        captures_added=len(np.unique(table.capture_ids[new])),
        captures_removed=int(gone.sum()),
        seconds_added=float(frames.sum()) / MOTION_FPS,
        explained_less=float(mean - (explained @ frames) / total) if len(frames) else 0.0,
        strange=strange / total,
        below_background=float(frames[below].sum()) / total,
        **shares,
        words=tuple(sorted(unknown)),
        relearn=bool(reasons),
        reasons=reasons,
    )


def _reasons(shares: dict[str, float], words: tuple[str, ...]) -> tuple[str, ...]:
    shown = ", ".join(words[:3]) + (", ..." if len(words) > 3 else "")
    texts = (
        ("strange_of_all", STRANGE, "of all motion is strange to the symbols"),
        ("new_words", NEW_WORDS, f"of all words written are new ({shown})"),
        ("turnover", TURNOVER, "as much motion came or went as it learned from"),
    )
    return tuple(f"{shares[key]:.0%} {text}" for key, limit, text in texts if shares[key] > limit)


def _frames(table: SegmentTable) -> FloatArray:
    return (table.ends - table.starts).astype(np.float64)


def _words(database: store.Store) -> tuple[int, dict[str, int]]:
    """How many words are written about captured captures, and how often each unknown one."""
    known = set(store.load_association(database).words)
    synonyms = store.load_synonyms(database)
    captured = {i.capture_id for i in store.load_captures(database) if i.kind == "captured"}
    said = 0
    unknown: dict[str, int] = {}
    for capture, captions in store.load_captions(database).items():
        for caption in captions if capture in captured else ():
            words = vocabulary.words_of(caption.words, synonyms)
            said += len(words)
            for word in words:
                if word not in known:
                    unknown[word] = unknown.get(word, 0) + 1
    return said, unknown
