"""Questions that find something in a database, to be offered to somebody who does not know it.

Each offered question was asked: its first answer is more likely right than wrong. Where the
captions have not checked the words, no answer has a probability; then only words are offered.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, pairwise

from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.language.question.heads import verbs_in
from motiondb.search.placing import LIKELY

OFFERED, MOST_ASKED = 5, 14  # Questions that are offered, and most that are tried for it
MOST_WORDS = 8  # Words that are offered where no question is proven
MOST_CAPTIONS = 40  # Captions whose own order of actions is tried


@dataclass(frozen=True)
class ProvenQuestion:
    """A question, and its first answer with the probability that it is right."""

    question: str
    capture: str
    probability: float


@dataclass(frozen=True)
class ExamplesReply:
    """Questions that find something, and the commonest actions in the captions."""

    examples: tuple[ProvenQuestion, ...]
    words: tuple[str, ...]


def examples_of(db: MotionDB) -> ExamplesReply:
    """Return questions that find something in a database; computed once a revision."""
    return db.session.kept("page examples", lambda: _find(db))


def _find(db: MotionDB) -> ExamplesReply:
    words = _action_words(db)
    proven: list[ProvenQuestion] = []
    shown: set[str] = set()
    for question in islice(_candidates(db, words), MOST_ASKED):
        if len(proven) == OFFERED:
            break
        found = _prove(db, question)
        if found is not None and found.capture not in shown:
            proven.append(found)
            shown.add(found.capture)
    return ExamplesReply(tuple(proven), tuple(words[:MOST_WORDS]))


def _action_words(db: MotionDB) -> list[str]:
    """Return the words that name actions, those in most captions first."""
    counted = [row.word for row in db.word_rows() if row.count > 0]
    return [word for word in counted if verbs_in(word) == {word}]


def _candidates(db: MotionDB, words: list[str]) -> Iterator[str]:
    """Yield questions: orders of actions that captions tell and single actions, by turns."""
    singles, orders = iter(words), _told_orders(db, set(words))
    for _ in range(MOST_ASKED):
        yield from islice(singles, 1)
        yield from islice(orders, 1)
    yield from (f"{a} or {b}" for a, b in pairwise(words))


def _told_orders(db: MotionDB, words: set[str]) -> Iterator[str]:
    """Yield two actions that a caption of a whole capture tells one after the other."""
    told: dict[str, None] = {}
    for row in db.browse(limit=10**6).rows:
        for caption in row.captions:
            pieces = [piece.strip() for piece in caption.words.lower().split(",")]
            named = [min(verbs_in(p) & words, default="") for p in pieces]
            told.update((f"{a}, {b}", None) for a, b in pairwise(named) if a and b and a != b)
        if len(told) > MOST_CAPTIONS:
            break
    yield from told


def _prove(db: MotionDB, question: str) -> ProvenQuestion | None:
    """Return a question whose first answer is more likely right than wrong, else None."""
    try:
        answer = db.search(question, limit=1)
    except QueryError:
        return None
    if not answer.matches or not answer.matches_anything:
        return None
    first = answer.matches[0]
    if first.probability is None or first.probability < LIKELY:
        return None
    return ProvenQuestion(question, first.capture, first.probability)
