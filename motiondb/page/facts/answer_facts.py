"""Facts of answers, for JSON: matches, and the known words that stand for unknown ones.

Times are in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from motiondb.records import Match
from motiondb.search.unknown_words import Taking


def match_facts(match: Match) -> dict[str, Any]:
    """Return the facts of one answer."""
    facts: dict[str, Any] = {
        "rank": match.rank,
        "capture": match.capture,
        "start": match.start,
        "end": match.end,
        "score": match.score,
        "probability": match.probability,
        "words": list(match.words),
    }
    return facts | place_facts(match)


def place_facts(match: Match) -> dict[str, Any]:
    """Return the interval of an answer to words and its probability; {} for other answers."""
    if not match.parts:
        return {}
    return {
        "interval_probability": match.interval_probability,
        "place": match.place,
        "parts": [asdict(part) for part in match.parts],
    }


def taken_facts(taken: Mapping[str, Taking]) -> dict[str, Any]:
    """Return the known words that stand for unknown words, with their probabilities."""
    return {word: taking.facts() for word, taking in taken.items()}
