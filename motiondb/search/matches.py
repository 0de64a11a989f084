"""What every answer says of its capture: seconds, the words that it shows, whether it was made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motiondb.language.vocabulary import as_said
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, Match
from motiondb.search.asked_words import AskedWords, learned_words
from motiondb.search.described import segment_words

_LIKELY, _WRITTEN = 0.5, 0.999  # Probabilities of words that an answer has, and of written ones
_MOST_WORDS = 6  # Of an answer


def to_seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    """An interval of a capture in seconds, from frames [start, end) at 30 a second."""
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def match_rows(matches: Sequence[Match]) -> list[dict[str, object]]:
    """The matches as rows of a table."""
    columns = ("rank", "capture", "start", "end", "probability", "words")
    return [{**{c: getattr(m, c) for c in columns}, "found": m.reason} for m in matches]


def shown_words(
    asked: AskedWords, capture: int, start: int, end: int, first: Sequence[str] = ()
) -> tuple[str, ...]:
    """Words that are learned or written for an interval (frames) of a capture, likeliest first.

    `first`: Words that come before the others where they are among them.
    Words whose probability no own caption has checked count only where they are written.
    """
    learned, written = asked.learned, {each.word for each in asked.written_words}
    known = replace(learned_words(learned), counts_captions=asked.counts_captions)
    every = learned.kept(
        f"words of segments, {known.counts_captions}",
        capture,
        lambda: segment_words(known, capture).probabilities,
    )
    table, rows = learned.segments, learned.rows[capture]
    starts, ends = table.starts[rows], table.ends[rows]
    within = np.minimum(ends, end) - np.maximum(starts, start)
    inside = 2 * within > np.minimum(ends - starts, end - start)
    seen = every[inside].max(axis=0, initial=0.0)
    seen = np.where(known.checked | (seen > _WRITTEN), seen, 0.0)
    above = np.flatnonzero(seen > _LIKELY)
    likely = [known.names[w] for w in above[np.argsort(-seen[above], kind="stable")]]
    likely.sort(key=lambda word: first.index(word) if word in first else len(first))
    said = asked.evidence.written.get(capture)
    also = [w for w in asked.added if w in written and said is not None]
    names = likely[:_MOST_WORDS]
    names += [w for w in also if said is not None and said[:, asked.numbers[w]].max() > 0.0]
    return tuple(map(as_said, names))


def mark_generated(learned: Learned, capture: int, before: str = "") -> str:
    """The word "generated" for a generated capture, otherwise nothing."""
    return f"{before}generated" if learned.captures[capture].kind == "generated" else ""
