"""What every answer says of its capture: seconds, the words that it shows, whether it was made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.language.vocabulary import as_said
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, Match
from motiondb.search.asked_words import AskedWords


def to_seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    """An interval of a capture in seconds, from frames [start, end) at 30 a second."""
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def match_rows(matches: Sequence[Match]) -> list[dict[str, object]]:
    """The matches as rows of a table."""
    columns = ("rank", "capture", "start", "end", "probability", "words")
    return [{**{c: getattr(m, c) for c in columns}, "found": m.reason} for m in matches]


def shown_words(asked: AskedWords, capture: int, words: Sequence[str]) -> tuple[str, ...]:
    """Asked words that are likelier than not in the capture.

    Words whose probability no own caption has checked count only where they are written.
    """
    number, take = asked.numbers, asked.evidence.takes[capture]
    top = np.maximum(take.windows.max(axis=0), take.whole)
    said = asked.evidence.written.get(capture)
    here = asked.checked if said is None else asked.checked | (said.max(axis=0) > 0.0)
    shown = (word for word in words if top[number[word]] > 0.0 and here[number[word]])
    return tuple(map(as_said, shown))


def mark_generated(learned: Learned, capture: int, before: str = "") -> str:
    """The word "generated" for a generated capture, otherwise nothing."""
    return f"{before}generated" if learned.captures[capture].kind == "generated" else ""
