"""Search by words.

**The captures that answer a question in words, best first, with reasons and certainty.**

Answers are ranked by their log-odds: those of the question's words at their places
(:mod:`motiondb.meaning.by_question`), to which every word adds its likeness to the caption that the
motion of the capture suggests (:mod:`motiondb.meaning.caption_map`). Where a question asks for an
order, or for what is measured (:mod:`motiondb.search.measured_answers`), the first answers that are
more likely right than wrong and that nothing speaks against come before the others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import prod
from typing import Any

import numpy as np

from motiondb.errors import QueryError
from motiondb.language.question.readings import KnownQuestion
from motiondb.language.question.tree import NotUsed
from motiondb.language.translation import decoding
from motiondb.language.vocabulary import as_said
from motiondb.learn.recognition import decode
from motiondb.records import Match
from motiondb.search import placing, reasons
from motiondb.search.asked_words import WrittenWord
from motiondb.search.asking import AskedQuestion
from motiondb.search.chances import (
    LIKELY,
    NOTHING,
    Found,
    WordSource,
    best_strength,
    reaches,
    why_unchecked,
    word_sources,
    words_of_reading,
)
from motiondb.search.matches import mark_generated, match_rows, shown_words, to_seconds
from motiondb.search.ranking import Judged
from motiondb.search.reasons import Explanation, explain
from motiondb.search.seen_frames import Features
from motiondb.search.steps import Place, Steps, answer_here, take
from motiondb.search.takings import Taking, say_not_understood, with_notation
from motiondb.search.word_steps import FindBest, PlaceAnswers, SayAnswers
from motiondb.tabled import Tabled

LOOKED_AT = 10  # Answers by which it is told whether anything matches, however many are shown
ORDERS_LOOKED_AT = 30  # The same for actions in order, which not all of them show in this order
MEASURED = 100  # The same for what is measured, and is hardly told by words
MOST_DECODED = 50
"""Largest number of words that are decoded to symbols at once: 200 words need 2 GB, and
sequences are short."""


@dataclass(frozen=True, eq=False, repr=False)
class WordAnswer(Tabled):
    """Matches of a question in words, and how the question was understood.

    Attributes
    ----------
    matches : tuple of Match
        Best first.
    question : KnownQuestion
        The parsed question.
    actions : tuple of tuple of str
        The question as a plain order of actions; () stands for any action.
    not_used : tuple of NotUsed
        Parts of the question that were not used in the search.
    decoding : Decoding or None
        Decoded symbols of a search by symbols; None if no sequence was found.
    reasons : tuple
        For each match, the contributions of the words to its log-odds; their
        ``motiondb.search.reasons.total`` is the number that ranks the match, and ``score`` its
        logistic function.
    strength : float or None
        Nats by which the least certain action, once, is more probable than usual for its words, in
        the answer that shows it best, of the first 10 (of an order 30, of what is measured 100).
    threshold : float or None
        Strength below which nothing in the database matches; None if it could not be learned
        (``meaning.regression``).
    taken : dict
        Word that is in no caption -> the known words that replace it.
    suggested : dict
        Word that is in no caption and was not replaced -> suggested known words.
    sources : tuple of WordSource
        The captions from which the words were learned, if the database learned with a start.
    written : tuple of WrittenWord
        Words that were not learned and were found where they are written.
    unchecked : str
        Why the answers carry no probabilities, where the database learned with a start and its own
        captions have not checked them; "" where they have (``motiondb.learn.checking``).
    vocabulary : tuple of str
        The words by number: those learned, then the written and the taken ones.
    missing : tuple of str
        Words that name an action of the question and are not understood. The answers are for the
        rest alone; they carry no probabilities, and whether any matches is not known.
    doubtful : bool
        Whether each of the first answers is more likely wrong than right, or some action, the
        order or what is measured is shown by none of them.
    measured : tuple of str
        Words that no caption holds and that are measured in the motion ("backward").
    unmeasured : tuple of str
        Words that were not measured because the question has alternatives or, of words that no
        caption holds, several actions. Its answers carry no probabilities, and whether any matches
        is not known.
    near : tuple of str
        The question, if probably nothing shows it, and the one with near words in place of its own
        for which the answers are; () otherwise.
    """

    matches: tuple[Match, ...]
    question: KnownQuestion
    actions: tuple[tuple[str, ...], ...]
    not_used: tuple[NotUsed, ...] = ()
    decoding: decoding.Decoding | None = None
    reasons: tuple[tuple[reasons.WordReason, ...], ...] = ()
    strength: float | None = None
    threshold: float | None = None
    taken: Mapping[str, Taking] = field(default_factory=dict)
    suggested: Mapping[str, Taking] = field(default_factory=dict)
    sources: tuple[WordSource, ...] = ()
    written: tuple[WrittenWord, ...] = ()
    unchecked: str = ""
    vocabulary: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    doubtful: bool = False
    measured: tuple[str, ...] = ()
    unmeasured: tuple[str, ...] = ()
    near: tuple[()] | tuple[str, str] = ()
    # For each match, finds the captions that its motion suggests
    suggests: tuple[Callable[[], tuple[str, ...]], ...] = field(default=(), repr=False)

    def _rows(self) -> tuple[str, list[dict[str, object]]]:
        title = "; ".join(filter(None, (self.not_understood, self.understood, self.nothing)))
        return title, match_rows(self.matches)

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Per match the parts of the log-odds that rank it; none for a search by symbols."""
        pairs = zip(self.reasons, self.suggests)
        said = tuple(map(as_said, self.vocabulary))
        return tuple(explain(why, said, suggests()) for why, suggests in pairs)

    @property
    def unknown(self) -> Mapping[str, tuple[str, ...]]:
        """Word of the question that is not known -> nearest known words."""
        return self.question.unknown

    @property
    def understood(self) -> str:
        """How the question is understood; words that are taken, measured or not, say so."""
        known = with_notation(self.question.understood, self.taken)
        for what, words in (("measured", self.measured), ("not measured", self.unmeasured)):
            known += f"; {what}: {', '.join(map(as_said, words))}" if words else ""
        return known

    @property
    def not_understood(self) -> str:
        """The words that are missing, and what is answered in place of the question."""
        if self.near:
            asked, near = self.near
            return f"probably nothing shows {asked!r}; these are answers for {near!r} in its place"
        rest = f"; these are answers for {self.question.understood!r} alone"
        return say_not_understood(self.missing) + (rest if self.missing else "")

    @property
    def nothing(self) -> str:
        """That nothing matches, or probably nothing; "" if something may."""
        if self.matches_anything is False:
            return NOTHING
        return f"probably {NOTHING}" if self.doubtful else ""

    @property
    def matches_anything(self) -> bool | None:
        """Whether anything in the database shows the requested actions; None if unknown."""
        reached = reaches(self.matches, self.strength, self.threshold)
        if any(taking.is_other for taking in self.taken.values()) and self.matches:
            return None
        if reached is False and self.matches:
            # the strength of an order is that of its weakest part, that of an action what captions
            # leave unsaid lowers too; the threshold is that of single words
            if len(self.matches[0].parts) > 1:
                reached = (self.matches[0].probability or 0.0) >= LIKELY
            elif any(why.written > 0.0 and why.exclusion < 0 for why in self.reasons[0]):
                return None
        return None if self.near or (reached and (self.doubtful or self.unmeasured)) else reached


def search_words(
    question: AskedQuestion,
    allowed: Sequence[int],
    limit: int = 10,
    written: bool = True,
    features: Features | None = None,
) -> WordAnswer:
    """The intervals that show what a question asks for, best first.

    `written`: Whether the captions of the captures count as evidence, in addition to the motion.
    `features`: Recognition features of a capture, by which the boundaries of intervals are refined
    and orders and directions are checked; without them they stay those of segments.
    """
    place = Place(allowed, features)
    return answer_here(word_steps(question, limit, written), place)


def word_steps(
    question: AskedQuestion, limit: int, written: bool = True
) -> Steps[AskedQuestion, WordAnswer]:
    """Answer a question that is no search by symbols; see :func:`search_words`."""
    if not written:
        question = replace(question, asked=question.asked.by_motion())
    asked, read, learned = question.asked, question.readings, question.asked.learned
    is_checked = question.is_order or question.is_measured
    n_judged = (
        MEASURED if question.is_measured else ORDERS_LOOKED_AT if question.is_order else LOOKED_AT
    )
    best = yield from take(question, FindBest(max(limit, n_judged), n_judged))
    found, judged = best.found, best.found[:n_judged]
    sure = learned.word_certainty
    unchecked = why_unchecked(asked, sorted(set().union(*map(words_of_reading, read))))
    known = sure is not None and not np.isnan(sure.threshold) and not unchecked
    threshold = sure.threshold if sure is not None and known else None
    replaced = prod(taking.chance for taking in question.taken.values() if taking.is_other)

    def rank(place: Callable[[Found], placing.Placed]) -> _Ranked:
        judge = Judged(judged, place, is_checked)
        first = judge.first(limit)
        shown = [*first, *found[n_judged:]][:limit]
        return _Ranked(
            tuple((judge.looked_at(each), place(each)) for each in shown),
            not question.missing and judge.is_doubtful(first, known, replaced),
        )

    ranked = yield from _placed_as_needed(question, found, rank)
    said = yield from take(question, SayAnswers(ranked.shown))
    shown = [answer.capture for answer, _ in ranked.shown]
    usual = [hit for _, hit in best.usual] or [each.hit for each in judged]
    return replace(
        _answer(question),
        matches=tuple(replace(said[n].match, rank=k) for k, n in enumerate(shown, start=1)),
        reasons=tuple(said[n].why for n in shown),
        strength=best_strength(asked, usual, threshold),
        threshold=None if question.missing else threshold,
        doubtful=ranked.is_doubtful,
        suggests=tuple(partial(learned.captions_like, n) for n in shown),
        vocabulary=asked.names,
        sources=word_sources(learned, question.words) + _sources_of_taken(question),
        written=asked.written_words,
        unchecked=unchecked,
    )


@dataclass(frozen=True)
class _Ranked:
    """The answers that are shown, with their places, and whether any is likely right."""

    shown: tuple[tuple[Found, placing.Placed], ...]
    is_doubtful: bool


class _NotPlacedError(Exception):
    """An answer whose place has to be asked for."""

    def __init__(self, answer: Found) -> None:
        self.answer = answer


def _placed_as_needed(
    question: AskedQuestion,
    answers: Sequence[Found],
    rank: Callable[[Callable[[Found], placing.Placed]], _Ranked],
) -> Steps[AskedQuestion, _Ranked]:
    """The answers as they are ranked by their places, of which few are asked for at a time."""
    told, n_more = list[Mapping[int, placing.Placed]](), LOOKED_AT
    asked_for = set[int]()

    def place(answer: Found) -> placing.Placed:
        for some in told:
            if answer.capture in some:
                return some[answer.capture]
        raise _NotPlacedError(answer)

    while True:
        try:
            return rank(place)
        except _NotPlacedError as error:
            at = next(n for n, a in enumerate(answers) if a.capture == error.answer.capture)
        new = [a for a in answers[at:] if a.capture not in asked_for][:n_more]
        asked_for.update(a.capture for a in new)
        n_more *= 2
        told.append((yield from take(question, PlaceAnswers(tuple(new)))))


def _answer(question: AskedQuestion) -> WordAnswer:
    """How a question was understood, without matches."""
    return WordAnswer(
        (),
        replace(question.known, text=question.text),
        question.actions,
        question.not_used,
        taken={**question.same, **question.taken},
        suggested={w: taking for w, taking in question.takings.items() if not taking.heard},
        sources=_sources_of_taken(question),
        missing=question.missing,
        measured=question.measured,
        unmeasured=question.unmeasured,
    )


def _sources_of_taken(question: AskedQuestion) -> tuple[WordSource, ...]:
    """The captions from which the known words that stand for others were learned."""
    behind = [word for taking in question.taken.values() for word in taking.heard]
    return word_sources(question.asked.learned, behind)


def as_near(answer: WordAnswer, asked: str, near: str) -> WordAnswer:
    """The answer to a near question, in place of that to the one that was asked."""
    unknown: dict[str, Any] = {"probability": None, "interval_probability": None}
    matches = tuple(
        replace(match, parts=tuple(replace(p, **unknown) for p in match.parts), **unknown)
        for match in answer.matches
    )
    return replace(answer, matches=matches, threshold=None, doubtful=False, near=(asked, near))


def search_decoded(question: AskedQuestion, allowed: Sequence[int], limit: int) -> WordAnswer:
    """The captures whose symbols are nearest to those that the actions of a question decode to."""
    from motiondb.meaning import alignment  # compiled code, which other questions do without

    asked, answer = question.asked, _answer(question)
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
