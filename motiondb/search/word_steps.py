"""The steps of a question in words: the best captures, where they show it, their answers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from motiondb.language.question.amounts import manner_of
from motiondb.language.question.readings import Reading, without_amounts
from motiondb.language.vocabulary import as_said
from motiondb.meaning import by_question
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.word_evidence import WhenAsked, upper_bounds
from motiondb.records import Match, MatchPart
from motiondb.search import placing, reasons
from motiondb.search.asking import AskedQuestion
from motiondb.search.chances import Found, are_checked, chances
from motiondb.search.matches import mark_generated, shown_words, to_seconds
from motiondb.search.measured_answers import compare_with_motion
from motiondb.search.ranking import likeliest_takes
from motiondb.search.reasons import explain_hit
from motiondb.search.seen_frames import Features, SeenFrames
from motiondb.search.steps import Place, joined
from motiondb.search.takings import with_notation


@dataclass(frozen=True)
class Best:
    """The best answers of some captures, best first."""

    found: tuple[Found, ...]
    # Capture and answer to the question once, without counts and durations: how often and how long
    # was never measured. Empty where the question has none
    usual: tuple[tuple[int, QuestionHit], ...]


@dataclass(frozen=True)
class FindBest:
    """The captures that answer a question best."""

    n: int  # Number of them
    n_usual: int  # Number of those that answer it best once

    def tell(self, question: AskedQuestion, place: Place) -> Best:
        """Those of a place."""
        asked, read = question.asked, question.readings
        once = tuple(map(without_amounts, read))
        chances_of = partial(chances, asked, read, are_checked(asked, read))
        find_them = partial(_find, question, place.captures)
        found = (Found(*each, chances_of(*each)) for each in find_them(self.n, read))
        return Best(tuple(found), () if once == read else tuple(find_them(self.n_usual, once)))

    def join(self, told: Sequence[Best]) -> Best:
        """Those of all places; of equal ones, the lowest numbers come first."""
        found = sorted(
            (each for best in told for each in best.found),
            key=lambda each: (-each.hit.log_odds, each.capture),
        )
        usual = sorted(
            (each for best in told for each in best.usual),
            key=lambda each: (-each[1].log_odds, each[0]),
        )
        return Best(tuple(found[: self.n]), tuple(usual[: self.n_usual]))


@dataclass(frozen=True)
class PlaceAnswers:
    """Where captures show the parts of their answers."""

    answers: tuple[Found, ...]

    def tell(self, question: AskedQuestion, place: Place) -> Mapping[int, placing.Placed]:
        """By capture; each is placed when it is asked for."""
        own = {each.capture: each for each in self.answers if each.capture in place.captures}
        return WhenAsked(own, lambda n: _place(question, own[n], place.features), len(own))

    def join(self, told: Sequence[Mapping[int, placing.Placed]]) -> Mapping[int, placing.Placed]:
        """Those of all places, by capture."""
        return joined(told)


@dataclass(frozen=True)
class Said:
    """An answer in words."""

    match: Match
    why: tuple[reasons.WordReason, ...]


@dataclass(frozen=True)
class SayAnswers:
    """Answers in words, with reasons."""

    answers: tuple[tuple[Found, placing.Placed], ...]

    def tell(self, question: AskedQuestion, place: Place) -> Mapping[int, Said]:
        """Those of a place, by capture."""
        said = dict[int, Said]()
        for answer, placed in self.answers:
            if answer.capture in place.captures:
                why = explain_hit(question.asked, answer.capture, answer.hit)
                said[answer.capture] = Said(_match(question, answer, placed, why), why)
        return said

    def join(self, told: Sequence[Mapping[int, Said]]) -> Mapping[int, Said]:
        """Those of all places, by capture."""
        return joined(told)


def _find(
    question: AskedQuestion,
    allowed: Collection[int],
    limit: int,
    read: Sequence[Reading],
) -> list[tuple[int, QuestionHit]]:
    """The best answers to some readings of a question with their captures, best first."""
    asked, number, verbs = question.asked, question.asked.numbers, question.sentence.verbs
    takes, extremes = asked.evidence.takes, asked.evidence.extremes
    searched = np.isin(extremes.captures, np.fromiter(allowed, np.int64, len(allowed)))
    return likeliest_takes(
        extremes.captures[searched],
        upper_bounds(extremes, read, number, verbs)[searched],
        lambda capture: by_question.search_take(takes[capture], read, number, verbs),
        limit,
    )


def _place(
    question: AskedQuestion,
    answer: Found,
    features: Features | None,
) -> placing.Placed:
    """Where a capture shows the parts of an answer, by segments and then by frames."""
    asked, capture = question.asked, answer.capture
    reading = question.readings[answer.hit.reading]
    places = placing.place_answer(asked, capture, answer.hit, reading, answer.sure.parts)
    placed = placing.Placed(places)
    if features is not None:
        seen = SeenFrames(asked.learned, capture, features)
        placed = placing.refine_places(asked, seen, reading, places)
        if question.is_measured:
            placed = compare_with_motion(question, seen, placed)
    return placing.sure_of_whole(placed, asked.learned.captures[capture].motion_frames)


def _match(
    question: AskedQuestion,
    answer: Found,
    placed: placing.Placed,
    why: Sequence[reasons.WordReason],
) -> Match:
    """One capture's answer: scored by the word map, placed by the evidence of places.

    How probably an answer for "walk" shows "limp", or what else of a question is not understood
    or not measured, is not known: such answers and parts carry no probabilities.
    """
    asked, capture, places = question.asked, answer.capture, placed.parts
    learned, reading = asked.learned, question.readings[answer.hit.reading]
    others = {word for word, taking in question.taken.items() if taking.is_other}
    is_silent = bool(question.unmeasured or question.missing)
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
    reason = (
        "; ".join(map(_say_part, parts))
        + ("; not seen in this order" if placed.in_order is False else "")
        + "".join(f"; measured: {words}" for words in placed.contradicted)
        + mark_generated(learned, capture, "; ")
    )
    whole = answer.sure.whole
    return Match(
        0,  # its rank is not known yet
        learned.captures[capture].name,
        *to_seconds(learned, capture, start, end),
        float(1.0 / (1.0 + np.exp(-reasons.total(why)))),
        shown_words(asked, capture, start, end, question.words),
        with_notation(reason, question.taken),
        whole if is_known else None,
        placing.interval_probability(whole, places, reading) if is_known else None,
        "unknown" if any(place.unknown for place in places) else "known",
        tuple(parts),
        placed.in_order,
        placed.contradicted,
    )


def _part_words(reading: Reading) -> list[str]:
    """The actions of every part of a reading."""
    said = []
    for k, part in enumerate(reading.parts):
        asked = [" ".join(map(as_said, action)) for action in part.actions]
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
        return f"{part.words} somewhere in {part.start:g}-{part.end:.1f} s, by its caption"
    return f"{part.words} {part.start:.2f}-{part.end:.2f} s"
