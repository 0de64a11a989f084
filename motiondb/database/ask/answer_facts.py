"""Facts of answers, for JSON: matches, reasons, how a question was understood.

The command line prints them with ``--json``; the page shows them. Times are in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from motiondb.records import MOTION_FPS, Match
from motiondb.search.questions import reasons
from motiondb.search.questions.reasons import WordReason
from motiondb.words.nearby.taking import Taking
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.say import say
from motiondb.words.question.tree import NotUsed, to_dict


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
    """Return where an answer to words is, and how sure; nothing for other answers."""
    if not match.parts:
        return {}
    return {
        "interval_probability": match.interval_probability,
        "place": match.place,
        "parts": [asdict(part) for part in match.parts],
    }


def question_facts(question: KnownQuestion, not_used: Sequence[NotUsed]) -> dict[str, Any]:
    """Return a question: its text, one line for how it is understood, its tree, what is left."""
    return {
        "text": question.text,
        "understood": say(question.tree),
        "tree": to_dict(question.tree),
        "not_used": [{"text": left.text, "reason": left.reason} for left in not_used],
    }


def taken_facts(taken: Mapping[str, Taking]) -> dict[str, Any]:
    """Return what words were taken as.

    Parameters
    ----------
    taken : mapping of str to Taking
        Words that are taken as known ones.
    """
    return {
        word: [{"word": known, "probability": p} for known, p in taking.words]
        for word, taking in taken.items()
    }


def reason_facts(words: Sequence[str], why: Sequence[WordReason]) -> dict[str, Any]:
    """Return the decomposition of one answer.

    ``math.fsum`` of all parts of ``words``, ``together`` and the amounts of ``excluded`` is
    ``log_odds``.

    Parameters
    ----------
    words : sequence of str
        The vocabulary.
    why : sequence of WordReason
        The reasons of the answer.
    """
    return {
        "log_odds": reasons.total(why),
        "together": reasons.together(why),
        "words": [_word_facts(words, w) for w in why if w.exclusion < 0],
        "excluded": [
            {
                "amount": lowering.amount,
                "log_odds": lowering.log_odds,
                "words": [_word_facts(words, w) for w in why if w.exclusion == lowering.exclusion],
            }
            for lowering in reasons.lowerings(why)
        ],
    }


def _word_facts(words: Sequence[str], w: WordReason) -> dict[str, Any]:
    return {
        "word": words[w.word],
        "log_odds": w.log_odds,
        "log_probability": w.log_probability,
        "contribution": w.contribution,
        "prior": w.prior,
        "written": w.written,
        "symbols": [
            {
                "symbol": s.symbol,
                "from": s.start / MOTION_FPS,
                "to": s.end / MOTION_FPS,
                "share": s.amount,
            }
            for s in w.shares
        ],
    }
