"""Facts of answers to questions: matches with their takes, and how the question was understood."""

from __future__ import annotations

from typing import Any

from motiondb.database import MotionDB
from motiondb.page.facts.answer_facts import match_facts, taken_facts
from motiondb.page.facts.capture_facts import caption_facts
from motiondb.records import Match
from motiondb.search.by_example import ExampleAnswer
from motiondb.search.by_words import WordAnswer
from motiondb.search.explained_answer import Explanation


def search_facts(db: MotionDB, answer: WordAnswer) -> dict[str, Any]:
    """Return the answer to a question in words, with the reasons of every match."""
    takings = (*answer.taken.values(), *answer.suggested.values())
    matches = [_with_take(db, match) for match in answer.matches]
    for row, why in zip(matches, answer.explanations):
        row["explain"] = _explained(why)
    return {
        "question": answer.question.facts(answer.not_used),
        "taken": taken_facts(answer.taken),
        "suggested": taken_facts(answer.suggested),
        "unknown": {word: list(near) for word, near in answer.unknown.items()},
        "sentences": [taking.sentence() for taking in takings],
        "sources": [source.sentence() for source in answer.sources],
        "unchecked": answer.unchecked,
        "decoding": answer.decoding,
        **_verdict(db, answer),
        "matches": matches,
    }


def _explained(why: Explanation) -> dict[str, Any]:
    """Return the facts of an explanation; for each word, the shares that ``--explain`` prints."""
    facts = why.facts()
    groups = [(facts["words"], why.words)]
    groups += [(row["words"], out.words) for row, out in zip(facts["excluded"], why.excluded)]
    for rows, words in groups:
        for row, word in zip(rows, words):
            row["strongest"] = [
                {"symbol": s.symbol, "from": s.start, "to": s.end, "share": s.amount}
                for s in word.strongest
            ]
            row["others"] = word.other_shares
    return facts


def like_facts(db: MotionDB, answer: ExampleAnswer) -> dict[str, Any]:
    """Return the answer to an example."""
    matches = [_with_take(db, match) for match in answer.matches]
    return _verdict(db, answer) | {"unchecked": answer.unchecked, "matches": matches}


def _verdict(db: MotionDB, answer: WordAnswer | ExampleAnswer) -> dict[str, Any]:
    return {
        "matches_anything": answer.matches_anything,
        "strength": answer.strength,
        "threshold": answer.threshold,
        "not_yet_learned": len(db.unlearned()),
    }


def _with_take(db: MotionDB, match: Match) -> dict[str, Any]:
    """Return a match with performer, licence, symbols and captions of its capture."""
    row = db.browsed(match.capture)
    assert row is not None  # both come from one revision
    return match_facts(match) | {
        "ref": f"capture:{match.capture}",
        "reason": match.reason,
        "duration": round(row.info.duration, 3),
        "performer": row.info.tags.get("performer"),
        "licence": row.info.tags.get("licence"),
        "kind": row.info.kind,
        "timeline": {
            "segments": db.segments(match.capture),
            "words": caption_facts(row.captions),
        },
    }
