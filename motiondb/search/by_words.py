"""Search by words.

**The captures that answer a question in words, best first, with reasons and certainty.**

Answers are ranked by their log-odds: those of the question's words at their places
(:mod:`motiondb.meaning.by_question`), to which every word adds its likeness to the caption that the
motion of the capture suggests (:mod:`motiondb.meaning.caption_map`). Where a question asks for an
order, or for what is measured (:mod:`motiondb.search.measured_answers`), the first answers that are
more likely right than wrong and that nothing speaks against come before the others.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.language.question.readings import KnownQuestion, Part, Reading
from motiondb.language.question.tree import NotUsed
from motiondb.language.vocabulary import as_said, say_not_understood
from motiondb.meaning import by_question
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.occurrences import event_of
from motiondb.meaning.travelled import turning
from motiondb.meaning.word_evidence import upper_bounds
from motiondb.records import Match
from motiondb.search import placing, reasons
from motiondb.search.asked_words import AskedWords, WrittenWord, words_of_reading
from motiondb.search.asking import COUNTED_EVENTS, AskedQuestion
from motiondb.search.chances import (
    LIKELY,
    NOTHING,
    Chances,
    Found,
    WordSource,
    best_strength,
    chances,
    is_one_action,
    reaches,
    why_unchecked,
    word_sources,
)
from motiondb.search.matches import match_rows
from motiondb.search.measured_answers import compare_with_motion, is_surely_against
from motiondb.search.ranking import Judged
from motiondb.search.reasons import Explanation, explain, explain_hit
from motiondb.search.seen_frames import Frames
from motiondb.search.takings import Taking, with_notation
from motiondb.search.word_matches import to_match
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from motiondb.language.translation import decoding

LOOKED_AT = 10  # Answers by which it is told whether anything matches, however many are shown
ORDERS_LOOKED_AT = 30  # The same for actions in order, which not all of them show in this order
MEASURED = 100  # The same for what is measured, and is hardly told by words
SEEN_ALONE = 1000  # The same for a posture that no caption says


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
        Words that are measured in the motion in place of searched ("backward", "fast").
    unmeasured : tuple of str
        Words that were not measured because the question has alternatives or, of words that no
        caption holds, several actions. Its answers carry no probabilities, and whether any matches
        is not known.
    near : tuple of str
        The question, if probably nothing shows it, and the one with near words in place of its own
        for which the answers are; () otherwise.
    apart : tuple of str
        Words of one action that no caption says together; answers are ranked by each of them.
    left : tuple of str
        Words that are neither searched nor measured; the answers carry no probabilities.
    partial : bool
        Whether each of the first answers is more likely wrong than right.
    looked_at : int
        How many captures' motion was looked at, if not that of all: what no caption says is looked
        for in a thousand captures.
    """

    matches: tuple[Match, ...]
    question: KnownQuestion
    actions: tuple[tuple[str, ...], ...]
    not_used: tuple[NotUsed, ...] = ()
    decoding: decoding.Decoding | None = None
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
    apart: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    partial: bool = False
    looked_at: int = 0
    # For each match, finds its reasons, and the captions that its motion suggests
    explains: tuple[Callable[[], tuple[reasons.WordReason, ...]], ...] = field(
        default=(), repr=False
    )
    suggests: tuple[Callable[[], tuple[str, ...]], ...] = field(default=(), repr=False)

    def __getstate__(self) -> dict[str, object]:
        """What another process gets: the explanations themselves, not what would find them."""
        made = {"reasons": self.reasons, "explanations": self.explanations}
        return {**vars(self), "explains": (), "suggests": (), **made}

    def _rows(self) -> tuple[str, list[dict[str, object]]]:
        left = [as_said(one.text) for one in self.not_used if one.text not in self.missing]
        unused = f"not used: {', '.join(dict.fromkeys(left))}" if left else ""
        said = self.not_understood, self.understood, unused, self.nothing
        title = "; ".join(filter(None, said))
        return title, match_rows(self.matches)

    @cached_property
    def reasons(self) -> tuple[tuple[reasons.WordReason, ...], ...]:
        """For each match, the contributions of the words to its log-odds.

        Their ``motiondb.search.reasons.total`` is the number that ranks the match, and ``score``
        its logistic function. None for a search by symbols.
        """
        return tuple(explain_one() for explain_one in self.explains)

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
    def remarks(self) -> tuple[str, ...]:
        """What else is to be said of the answers, in sentences."""
        said = [f"{word!r}" for word in map(as_said, self.apart)]
        left = [as_said(word) for word in self.left if word not in self.unknown]
        told = {
            f"no caption says {' and '.join(said)} of one action; ranked by each": said,
            f"neither said with its action nor measured: {', '.join(left)}": left,
            "probably no capture shows all of it; these show parts of it": self.partial
            and not self.nothing,
            f"looked at the motion of {self.looked_at:,} captures, not of all": self.looked_at,
        }
        return tuple(sentence for sentence, is_so in told.items() if is_so)

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
        unsure = self.doubtful or self.unmeasured or self.partial or self.apart
        return None if self.near or (reached and unsure) else reached


def search_words(
    question: AskedQuestion,
    allowed: Collection[int],
    limit: int = 10,
    written: bool = True,
    frames: Frames | None = None,
) -> WordAnswer:
    """The intervals that show what a question asks for, best first; no search by symbols.

    `written`: Whether the captions of the captures count as evidence, in addition to the motion.
    `frames`: Those of a capture, by which the boundaries of intervals are refined, and orders and
    what is measured are checked; without them they stay those of segments.
    """
    if not written:
        question = replace(question, asked=question.asked.by_motion())
    asked, read, learned = question.asked, question.readings, question.asked.learned
    is_checked = question.is_order or question.is_measured
    n_judged = (
        MEASURED if question.is_measured else ORDERS_LOOKED_AT if question.is_order else LOOKED_AT
    )
    is_told = not question.is_silent
    # measured, an answer may show another reading than the words say it shows best
    apart = [(one,) for one in read] if question.is_measured else [read]
    is_any_of = len(apart) > 1 and all(map(is_one_action, read))
    certain = partial(_chances_alone if is_any_of else chances, asked, read, is_told)
    found, rest = list[Found](), list[Found]()
    for n, some in enumerate(apart):
        n_looked_at = SEEN_ALONE if question.is_wordless(some) else n_judged
        best = _find(question, allowed, max(limit, n_looked_at), some)
        of_it = [Found(c, replace(hit, reading=n + hit.reading), certain) for c, hit in best]
        found, rest = found + of_it[:n_looked_at], rest + of_it[n_looked_at:]
    judged = _by_odds(found)
    unchecked = why_unchecked(asked, sorted(set().union(*map(words_of_reading, read))))
    sure = learned.word_certainty
    known = sure is not None and not np.isnan(sure.threshold) and not unchecked
    known = known and not (question.is_seen_alone or question.names_no_action)
    threshold = sure.threshold if sure is not None and known else None
    replaced = prod(taking.chance for taking in question.taken.values() if taking.is_other)

    place = cache(partial(_place, question, frames=frames))  # few are looked at, some twice
    shown_alone = cache(partial(_best_alone, question, allowed, is_told))
    contradicts = cache(partial(_is_surely_against, question, frames))
    judge = Judged(judged, place, is_checked, contradicts, shown_alone, question.sign)
    first = judge.first(limit)
    ranked = {each.capture: each for each in first}
    for answer in _by_odds(rest):
        ranked.setdefault(answer.capture, answer)
    shown = list(ranked.values())[:limit]
    once = tuple(map(_without_amounts, read))  # how often and how long was never measured
    n_usual = 1 if len(once) == 1 and is_one_action(once[0]) else n_judged  # the best is enough
    usual = [] if once == read else [hit for _, hit in _find(question, allowed, n_usual, once)]
    hits = usual or [each.hit for each in judged]
    strength = best_strength(asked, hits, threshold)
    if threshold is not None and strength is not None and strength < threshold:
        alone = [each.hit for words in _requested(hits) if (each := shown_alone(words))]
        numbers = {hit.reading for hit in hits}
        alone = [replace(hit, reading=number) for hit in alone for number in numbers]
        strength = best_strength(asked, [*hits, *alone], threshold)
    is_wordless = any(map(question.is_wordless, apart))
    is_open = bool(question.missing) or question.names_no_action
    is_open = is_open or any(_shows_event(question, frames, one, place(one)) for one in shown)
    return replace(
        as_understood(question),
        matches=tuple(
            to_match(question, rank, judge.looked_at(answer), place(answer))
            for rank, answer in enumerate(shown, start=1)
        ),
        explains=tuple(partial(explain_hit, asked, each.capture, each.hit) for each in shown),
        strength=strength,
        threshold=None if question.missing else threshold,
        doubtful=not is_open and judge.is_doubtful(first, known, replaced),
        partial=not is_open and judge.is_unlikely(first, known, replaced),
        looked_at=SEEN_ALONE if is_wordless and len(allowed) > SEEN_ALONE else 0,
        suggests=tuple(partial(learned.captions_like, answer.capture) for answer in shown),
        vocabulary=asked.names,
        sources=word_sources(learned, question.words) + _sources_of_taken(question),
        written=asked.written_words,
        unchecked=unchecked,
    )


def _find(
    question: AskedQuestion,
    allowed: Collection[int],
    limit: int,
    read: Sequence[Reading],
) -> list[tuple[int, QuestionHit]]:
    """The best answers to some readings of a question with their captures, best first."""
    asked, number = question.asked, question.asked.numbers
    takes, extremes = asked.evidence.takes, asked.evidence.extremes
    searched = np.isin(extremes.captures, np.fromiter(allowed, np.int64, len(allowed)))
    return by_question.likeliest_takes(
        extremes.captures[searched],
        upper_bounds(extremes, read, number)[searched],
        lambda capture: by_question.search_take(takes[capture], read, number),
        limit,
    )


def _shows_event(
    question: AskedQuestion, frames: Frames | None, answer: Found, placed: placing.Placed
) -> bool:
    """Whether the frames of an answer show the event that is all of a question.

    Of turns, those by the angle that is asked for: who walks turns, too. Other events count where
    the word for them was replaced, so that captions do not tell.
    """
    read = question.readings
    if frames is None or placed.contradicted or len(read) > 1 or len(read[0].parts) > 1:
        return False
    (part,), actions = read[0].parts, question.compared[0][0]
    if read[0].exclusions or len(actions) != 1:
        return False
    event = event_of(actions[0])
    if event == "turn" or part.measure is not None:
        return bool(turning(actions[0]) and placed.gauged)
    is_replaced = any(taking.is_other for taking in question.taken.values())
    is_all = not question.not_used and [*map(len, part.actions)] == [1]
    if event not in COUNTED_EVENTS or not is_replaced or not is_all:
        return False
    start, end = placed.parts[0].start, placed.parts[0].end
    seen = frames.of(question.asked.learned, answer.capture).events(event)
    return any(a < end and b > start for a, b in seen)


def _by_odds(found: Sequence[Found]) -> list[Found]:
    """Answers by their log-odds, the largest first; of equal ones, the lowest capture."""
    return sorted(found, key=lambda one: (-one.hit.log_odds, one.capture))


def _chances_alone(
    asked: AskedWords, read: Sequence[Reading], is_told: bool, capture: int, hit: QuestionHit
) -> Chances:
    """Certainty of an answer to one of several readings, as if that alone was asked."""
    return chances(asked, (read[hit.reading],), is_told, capture, replace(hit, reading=0))


def _requested(hits: Sequence[QuestionHit]) -> list[tuple[int, ...]]:
    """The actions of which every reading of some answers asks for each; none where it excludes."""
    each = [dict.fromkeys(s.words for s in hit.statements) for hit in hits]
    if any(s.exclusion >= 0 for hit in hits for s in hit.statements):
        return []
    return (
        list(each[0]) if each and len(each[0]) > 1 and len(set(map(frozenset, each))) == 1 else []
    )


def _best_alone(
    question: AskedQuestion, allowed: Collection[int], is_told: bool, words: tuple[int, ...]
) -> Found | None:
    """The best answer to one action of a question alone; None if there is none."""
    names = question.asked.names
    alone = (Reading((Part((tuple(names[word] for word in words),)),)),)
    certain = partial(chances, question.asked, alone, is_told)
    found = _find(question, allowed, 1, alone)
    return Found(*found[0], certain) if found else None


def _place(question: AskedQuestion, answer: Found, frames: Frames | None) -> placing.Placed:
    """Where a capture shows the parts of an answer, by segments and then by frames."""
    asked, capture = question.asked, answer.capture
    reading = question.readings[answer.hit.reading]
    places = placing.place_answer(asked, capture, answer.hit, reading, answer.sure.parts)
    placed = placing.Placed(places)
    if frames is not None:
        seen = frames.of(asked.learned, capture)
        placed = placing.refine_places(asked, seen, reading, places)
        if question.is_measured or len(question.readings) == 1:
            placed = compare_with_motion(question, seen, placed, answer.hit.reading)
    return placing.sure_of_whole(placed, asked.learned.captures[capture].motion_frames)


def _is_surely_against(question: AskedQuestion, frames: Frames | None, answer: Found) -> bool:
    """Whether a capture contradicts a question as measured, wherever it may show it."""
    if frames is None or not question.is_measured:
        return False
    seen = frames.of(question.asked.learned, answer.capture)
    return is_surely_against(question, seen, answer.hit.reading)


def as_understood(question: AskedQuestion) -> WordAnswer:
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
        apart=question.apart,
        left=question.left,
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
    return replace(
        answer, matches=matches, threshold=None, doubtful=False, partial=False, near=(asked, near)
    )


def _without_amounts(reading: Reading) -> Reading:
    """A reading without repeats and durations; one with exclusions stays as it is.

    >>> jump = (("jump",),)
    >>> plain = _without_amounts(Reading((Part(jump), Part(jump), Part((("sit",),), 2.0, 2))))
    >>> [(part.actions, part.seconds, part.repeat_of) for part in plain.parts]
    [((('jump',),), 0.0, 0), ((('sit',),), 0.0, 1)]
    """
    if reading.exclusions:
        return reading
    once = [part for k, part in enumerate(reading.parts) if part.repeat_of == k]
    return Reading(tuple(replace(p, seconds=0.0, repeat_of=n) for n, p in enumerate(once)))
