"""Search by symbols: the words are decoded to symbols, which captures are aligned with.

An answer has the probability of a search by words, that its capture shows the actions; what symbols
say of a capture was never calibrated: a symbol of *dribble* is also one of climbing. The score is
this probability times the similarity of the symbols, which is 1 where they occur as decoded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.errors import QueryError
from motiondb.learn.recognition import decode
from motiondb.meaning import alignment
from motiondb.records import Match
from motiondb.search.asking import AskedQuestion
from motiondb.search.by_words import WordAnswer, as_understood
from motiondb.search.matches import mark_generated, shown_words, to_seconds

MOST_DECODED = 50
"""Largest number of words that are decoded to symbols at once: 200 words need 2 GB, and
sequences are short."""


@dataclass(frozen=True)
class _Hit:
    """A part of a capture that is aligned with the symbols."""

    capture: int
    start: int  # Feature frames
    end: int
    similarity: float
    probability: float | None

    def score(self, least: float) -> float:
        """What orders the answers; `least` stands for a probability that is not known."""
        return self.similarity * (least if self.probability is None else self.probability)


def search_decoded(
    question: AskedQuestion, allowed: Sequence[int], limit: int, shown: Mapping[str, Match]
) -> WordAnswer:
    """The captures whose symbols are nearest to those that the actions of a question decode to.

    `shown`: Answers of a search by words, by the names of their captures.
    """
    asked, answer = question.asked, as_understood(question)
    learned = asked.learned
    words = tuple(word for action in question.actions for word in action)
    if len(words) > MOST_DECODED:
        raise QueryError(
            f"search --by-symbols: expected at most {MOST_DECODED} words, found {len(words)}. "
            "Ask for fewer actions, or leave out --by-symbols."
        )
    if not words:
        raise QueryError(
            "search --by-symbols: expected an action that captions say, found none. Leave out "
            "--by-symbols."
        )
    decoded = decode(learned, words)
    if decoded is None:
        return answer
    symbols = np.array(decoded.symbols)
    weights = np.full(len(symbols), 1.0 / len(symbols))
    scale = alignment.distance_scale(learned.distances)
    hits: list[_Hit] = []
    for capture in (c for c in allowed if c in learned.rows):
        rows = learned.rows[capture]
        similarity, first, last = alignment.align(
            symbols, weights, learned.segments.symbols[rows], learned.distances, scale
        )
        if last > first:
            start = int(learned.segments.starts[rows][first])
            end = int(learned.segments.ends[rows][last - 1])
            in_words = shown.get(learned.captures[capture].name)
            chance = None if in_words is None else in_words.probability
            hits.append(_Hit(capture, start, end, float(similarity), chance))
    known = [hit.probability for hit in hits if hit.probability is not None]
    least = min(known, default=1.0)  # an answer of which nothing is known is no better than that
    hits.sort(key=lambda hit: (-hit.score(least), hit.capture))
    occurs = any(np.isclose(hit.similarity, 1.0) for hit in hits)
    note = "" if occurs else "; this sequence of symbols does not occur; these are the nearest ones"
    text = " ".join(map(str, decoded.symbols))
    matches = tuple(
        Match(
            rank,
            learned.captures[hit.capture].name,
            *to_seconds(learned, hit.capture, hit.start, hit.end),
            hit.score(least),
            shown_words(asked, hit.capture, hit.start, hit.end, question.words),
            f"symbols {text}, similarity {hit.similarity:.2f}{note}"
            + mark_generated(learned, hit.capture, "; "),
            probability=hit.probability,
        )
        for rank, hit in enumerate(hits[:limit], start=1)
    )
    return replace(answer, matches=matches, decoding=decoded)
