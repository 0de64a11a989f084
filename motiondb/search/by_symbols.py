"""Search by symbols: the words are decoded to symbols, which captures are aligned with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

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


def search_decoded(question: AskedQuestion, allowed: Sequence[int], limit: int) -> WordAnswer:
    """The captures whose symbols are nearest to those that the actions of a question decode to."""
    asked, answer = question.asked, as_understood(question)
    learned = asked.learned
    words = tuple(word for action in question.actions for word in action)
    if len(words) > MOST_DECODED:
        raise QueryError(
            f"search --by-symbols: expected at most {MOST_DECODED} words, found {len(words)}. "
            "Ask for fewer actions, or leave out --by-symbols."
        )
    decoded = decode(learned, words)
    if decoded is None:
        return answer
    symbols = np.array(decoded.symbols)
    weights = np.full(len(symbols), 1.0 / len(symbols))
    scale = alignment.distance_scale(learned.distances)
    answers = []
    for capture in (c for c in allowed if c in learned.rows):
        rows = learned.rows[capture]
        score, first, last = alignment.align(
            symbols, weights, learned.segments.symbols[rows], learned.distances, scale
        )
        if last > first:
            start = int(learned.segments.starts[rows][first])
            answers.append((score, capture, start, int(learned.segments.ends[rows][last - 1])))
    answers.sort(key=lambda hit: (-hit[0], hit[1]))
    occurs = any(np.isclose(hit[0], 1.0) for hit in answers)
    note = "" if occurs else "; this sequence of symbols does not occur; these are the nearest ones"
    matches = tuple(
        Match(
            rank,
            learned.captures[capture].name,
            *to_seconds(learned, capture, start, end),
            float(score),
            shown_words(asked, capture, start, end, question.words),
            f"symbols {' '.join(str(s) for s in decoded.symbols)}{note}"
            + mark_generated(learned, capture, "; "),
        )
        for rank, (score, capture, start, end) in enumerate(answers[:limit], start=1)
    )
    return replace(answer, matches=matches, decoding=decoded)
