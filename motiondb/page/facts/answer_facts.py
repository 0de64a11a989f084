"""Facts of answers, for JSON: matches, reasons, how a question was understood.

Times are in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from motiondb.learning.answers.explained_answer import ExplainedWord, Explanation
from motiondb.records import Match
from motiondb.words.nearby.taking import Taking
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.tree import NotUsed


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
        "understood": question.understood,
        "tree": question.tree_facts(),
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


def explanation_facts(why: Explanation) -> dict[str, Any]:
    """Return the decomposition of one answer.

    ``math.fsum`` of all parts of ``words``, ``together`` and the amounts of ``excluded`` is
    ``log_odds``.
    """
    return {
        "log_odds": why.log_odds,
        "together": why.together,
        "words": [_word_facts(word) for word in why.words],
        "excluded": [
            {
                "amount": excluded.amount,
                "log_odds": excluded.log_odds,
                "words": [_word_facts(word) for word in excluded.words],
            }
            for excluded in why.excluded
        ],
    }


def _word_facts(word: ExplainedWord) -> dict[str, Any]:
    return {
        "word": word.word,
        "log_odds": word.log_odds,
        "log_probability": word.log_probability,
        "contribution": word.contribution,
        "prior": word.prior,
        "written": word.written,
        "symbols": [
            {"symbol": s.symbol, "from": s.start, "to": s.end, "share": s.amount}
            for s in word.shares
        ],
    }
