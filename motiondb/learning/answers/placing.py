"""Where an answer shows each part of a question, and how sure that is.

Which captures answer, and how far, is decided by the word map (``search.by_question``). Where in
the capture is decided by the evidence of places (:mod:`motiondb.learning.place_fitting`), with what
captions of intervals say. Two probabilities belong to a part: that the capture shows it, and that
the interval does, which is the first times the probability that the place is right where the
capture shows it (:mod:`motiondb.learning.certainty.place_certainty`).

The place is unknown where the interval is likelier wrong than right and only a caption of the whole
capture speaks for the part: without the caption the motion does not show it more likely than not.

Databases that learned before there was evidence of places keep the intervals of the word map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np

from motiondb.learning.certainty.place_certainty import cues_of
from motiondb.learning.learned import Learned
from motiondb.search import certainty
from motiondb.search.questions import by_question, reasons
from motiondb.search.questions.by_question import PlacedReading, QuestionHit
from motiondb.words.question.readings import Part, Reading

LIKELY = 0.5
"""Probability from which on a statement is likelier true than not."""


@dataclass(frozen=True)
class PartPlace:
    """Where a capture shows one part of a question.

    Attributes
    ----------
    start : int
        First frame; that of the whole capture where the place is unknown.
    end : int
        Last frame + 1; that of the whole capture where the place is unknown.
    probability : float or None
        That the capture shows it; None where it is not known.
    right : float or None
        That the interval is the right one, where the capture shows it; None where it is not known.
    unknown : bool
        Whether the place is unknown.
    """

    start: int
    end: int
    probability: float | None
    right: float | None = None
    unknown: bool = False

    @property
    def interval_probability(self) -> float | None:
        """That the interval shows the part; None where this or the place is not known."""
        if self.unknown or self.probability is None or self.right is None:
            return None
        return self.probability * self.right


@dataclass(frozen=True)
class _Said:
    """How sure a capture shows a part: with captions, by motion alone, and if captions say it."""

    probability: float
    by_motion: float
    by_caption: bool


def place_answer(
    learned: Learned,
    capture: int,
    hit: QuestionHit,
    reading: Reading,
    why: Sequence[reasons.WordReason],
    written: bool = True,
) -> tuple[PartPlace, ...]:
    """Where a capture shows every part of a reading.

    Parameters
    ----------
    learned : Learned
        What was learned.
    capture : int
        Number of the capture.
    hit : QuestionHit
        The answer.
    reading : Reading
        The reading that it answers.
    why : sequence of WordReason
        The reasons of the answer.
    written : bool
        Whether captions count as evidence beside the motion.
    """
    weighed = not counts_or_lasts(reading)  # how sure counts and lengths are was never learned
    said = [_said(learned, hit, reading, k, why) if weighed else None
            for k in range(len(reading.parts))]  # fmt: skip
    sure = [None if one is None else one.probability for one in said]
    placed = _placed(learned, capture, reading, written)
    if placed is None:
        return tuple(PartPlace(*span, p) for span, p in zip(hit.parts, sure))
    ends = int(placed.starts[0]), int(placed.ends[-1])
    found = []
    for k, (first, behind) in enumerate(placed.spans):
        span = int(placed.starts[first]), int(placed.ends[behind - 1])
        right = _right(learned, placed, k) if weighed and reading.parts[k].actions else None
        labelled = written and _is_labelled(learned, capture, reading.parts[k])
        unknown = not labelled and _only_by_caption(said[k], right)
        found.append(PartPlace(*(ends if unknown else span), sure[k], right, unknown))
    return tuple(found)


def interval_probability(
    probability: float | None, parts: Sequence[PartPlace], reading: Reading
) -> float | None:
    """Probability that the intervals of an answer show what was asked; None: not known.

    Parameters
    ----------
    probability : float or None
        Probability that the capture shows it.
    parts : sequence of PartPlace
        Places of the parts of the question.
    reading : Reading
        The reading of the question that was answered.
    """
    asked = [place for place, part in zip(parts, reading.parts) if part.actions]
    right = [place.right for place in asked if place.right is not None and not place.unknown]
    if probability is None or not asked or len(right) < len(asked):
        return None
    return probability * prod(right)


def counts_or_lasts(reading: Reading) -> bool:
    """Whether a reading asks for repeats or lengths."""
    return any(part.seconds > 0.0 or part.repeat_of != k for k, part in enumerate(reading.parts))


def _placed(
    learned: Learned, capture: int, reading: Reading, written: bool
) -> PlacedReading | None:
    """Places by the evidence of places; None without it, or where it has no room for the parts.

    There is none for words that no caption held when the database learned.
    """
    take = learned.place_takes.get(capture)
    asked = {learned.word_numbers[w] for part in reading.parts for a in part.actions for w in a}
    if take is None or not asked <= learned.placed_words:
        return None
    said = learned.said_places.get(capture) if written else None
    if said is not None:
        take = replace(take, windows=take.windows + said)
    return by_question.place_reading(take, reading, learned.word_numbers)


def _right(learned: Learned, placed: PlacedReading, k: int) -> float | None:
    """Probability that the interval of a part is right; None where it was not learned."""
    sure = learned.certainties.place
    if sure is None:
        return None
    return float(certainty.probability(sure.log_odds(cues_of(placed.values[k], *placed.spans[k]))))


def _said(
    learned: Learned,
    hit: QuestionHit,
    reading: Reading,
    k: int,
    why: Sequence[reasons.WordReason],
) -> _Said | None:
    """How sure a capture shows part k; None where it asks for nothing or nothing was learned."""
    sure = learned.word_certainty
    asked = [n for n, statement in enumerate(hit.statements) if statement.exclusion < 0]
    of_part = {n for n in asked if hit.statements[n].part == k}
    own = [odds for n, odds in zip(asked, reasons.by_action(why)) if n in of_part]
    if sure is None or not reading.parts[k].actions or not own:
        return None
    heard = [float(sure.log_odds(np.array([odds - said]))) for odds, said in own]
    return _Said(
        prod(float(certainty.probability(h + said)) for h, (_, said) in zip(heard, own)),
        prod(float(certainty.probability(h)) for h in heard),
        all(reason.written > 0.0 for reason in why if reason.action in of_part),
    )


def _only_by_caption(said: _Said | None, right: float | None) -> bool:
    """Whether a place is likelier wrong than right, and only a caption speaks for the part."""
    if said is None or right is None:
        return False
    return right < LIKELY and said.by_caption and said.by_motion < LIKELY


def _is_labelled(learned: Learned, capture: int, part: Part) -> bool:
    """Whether captions of intervals say all words of a part."""
    said = learned.said_places.get(capture)
    words = [learned.word_numbers[word] for action in part.actions for word in action]
    return said is not None and bool((said[:, words].max(axis=0) > 0.0).all())
