"""What an answer to a question in words says: its intervals, with probabilities and a reason."""

from __future__ import annotations

import numpy as np

from motiondb.language.question.amounts import manner_of
from motiondb.language.question.readings import Reading
from motiondb.language.vocabulary import as_said
from motiondb.meaning.regression import probability
from motiondb.records import Match, MatchPart
from motiondb.search import placing
from motiondb.search.asking import AskedQuestion
from motiondb.search.chances import Found
from motiondb.search.matches import mark_generated, shown_words, to_seconds
from motiondb.search.takings import with_notation


def to_match(
    question: AskedQuestion,
    rank: int,
    answer: Found,
    placed: placing.Placed,
) -> Match:
    """One capture's answer: scored by the word map, placed by the evidence of places.

    How probably an answer for "walk" shows "limp", or what else of a question is not understood
    or not measured, is not known: such answers and parts carry no probabilities.
    """
    asked, capture, places = question.asked, answer.capture, placed.parts
    learned, reading = asked.learned, question.readings[answer.hit.reading]
    others = {word for word, taking in question.taken.items() if taking.is_other}
    is_silent = bool(question.unmeasured or question.missing or question.left or question.apart)
    is_silent = is_silent or bool(question.not_used) or question.degree is not None
    is_silent = is_silent or any(part.is_seen or part.measure for part in reading.parts)
    is_silent = is_silent or bool(reading.unseen)
    parts = []
    for words, place in zip(_part_words(reading), places):
        is_known = not is_silent and others.isdisjoint(words.split())
        parts.append(
            MatchPart(
                words,
                *to_seconds(learned, capture, place.start, place.end),
                place.probability if is_known else None,
                place.interval_probability if is_known else None,
                "unknown" if place.unknown else "known",
            )
        )
    is_known = not (is_silent or others)
    start, end = min(p.start for p in places), max(p.end for p in places)
    measured = (*placed.contradicted, *placed.gauged, *_degree(question, placed))
    reason = (
        with_notation("; ".join(map(_say_part, parts)), question.taken)
        + ("; not seen in this order" if placed.in_order is False else "")
        + "".join(f"; measured: {words}" for words in measured)
        + mark_generated(learned, capture, "; ")
    )
    whole = answer.sure.whole
    return Match(
        rank,
        learned.captures[capture].name,
        *to_seconds(learned, capture, start, end),
        float(probability(answer.hit.log_odds)),
        shown_words(asked, capture, start, end, question.words),
        reason,
        whole if is_known else None,
        placing.interval_probability(whole, places, reading) if is_known else None,
        "unknown" if any(place.unknown for place in places) else "known",
        tuple(parts),
        placed.in_order,
        placed.contradicted,
    )


def _degree(question: AskedQuestion, placed: placing.Placed) -> tuple[str, ...]:
    """How fast, high or far an answer goes, if the question names that."""
    if (
        question.degree is None
        or not question.degree.sign
        or placed.amount is None
        or np.isnan(placed.amount)
    ):
        return ()
    return (question.degree.say(placed.amount),)


def _part_words(reading: Reading) -> list[str]:
    """The actions of every part of a reading."""
    said = []
    for k, part in enumerate(reading.parts):
        asked = [" ".join(map(as_said, action)) for action in part.actions or part.said]
        only = [e for e in reading.exclusions if (e.first, e.last) == (k, k + 1)]
        excluded = [
            f"not {' and '.join(' '.join(map(as_said, a)) for a in e.actions)}" for e in only
        ]
        together = "".join(
            text if n == 0 else f" {text}" if manner_of(text) else f" while {text}"
            for n, text in enumerate(asked)
        )
        said.append(together or ", ".join(excluded) or "?")
    return said


def _say_part(part: MatchPart) -> str:
    """A part of an answer with its interval, or that its place is unknown."""
    if part.place == "unknown":
        return f"{part.words} somewhere in {part.start:g}-{part.end:.1f} s, as written"
    return f"{part.words} {part.start:.2f}-{part.end:.2f} s"
