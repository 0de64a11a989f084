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
from typing import TypeVar

import numpy as np

from motiondb.errors import QueryError
from motiondb.language.question.amounts import manner_of
from motiondb.language.question.heads import verbs_in
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import (
    KnownQuestion,
    Reading,
    hinted,
    plain_actions,
    readings,
    with_hints,
    without_amounts,
)
from motiondb.language.question.tree import NotUsed, actions_of
from motiondb.language.translation import decoding
from motiondb.language.vocabulary import as_said
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import decode
from motiondb.meaning import word_evidence
from motiondb.meaning.word_evidence import WRITTEN
from motiondb.records import MOTION_FPS, Match, MatchPart
from motiondb.search import placing, reasons
from motiondb.search.asked_words import AskedWords, WrittenWord
from motiondb.search.chances import (
    WordSource,
    why_unchecked,
    word_sources,
    words_of_reading,
)
from motiondb.search.finding import Found, find
from motiondb.search.measured_answers import (
    compare_with_motion,
    is_measured,
    measured_words,
    only_action,
    unmeasured_words,
    without_measured,
)
from motiondb.search.nothing_matches import NOTHING, best_strength, is_doubtful, reaches
from motiondb.search.reasons import Explanation, explain
from motiondb.search.said_together import without_words_apart
from motiondb.search.takings import Taking, hints_of, say_not_understood, understand, with_notation

LOOKED_AT = 10  # Answers by which it is told whether anything matches, however many are shown
ORDERS_LOOKED_AT = 30  # The same for actions in order, which not all of them show in this order
MEASURED = 100  # The same for what is measured, and is hardly told by words
MOST_DECODED = 50
"""Largest number of words that are decoded to symbols at once: 200 words need 2 GB, and
sequences are short."""


QUOTES = (('"', '"'), ("\u201c", "\u201d"), ("\u201e", "\u201c"))
"""Pairs of quotation marks, which may stand around a question."""


@dataclass(frozen=True, eq=False)
class WordAnswer:
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
        is_other = any(taking.is_other for taking in self.taken.values())
        if is_other and (reached or (self.matches and len(self.matches[0].parts) > 1)):
            return None
        if reached is False and self.matches and len(self.matches[0].parts) > 1:
            # the strength of an order is that of its weakest part, the threshold of single actions
            reached = (self.matches[0].probability or 0.0) >= placing.LIKELY
        return None if self.near or (reached and (self.doubtful or self.unmeasured)) else reached


def search_words(
    asked: AskedWords,
    text: str,
    allowed: Sequence[int],
    limit: int = 10,
    by_symbols: bool = False,
    written: bool = True,
    features: placing.Features | None = None,
) -> WordAnswer:
    """The intervals that show what a text asks for, best first.

    ``limit``, ``by_symbols`` and ``written`` are those of ``MotionDB.search``.

    `features`: Recognition features of a capture, by which the boundaries of intervals are refined;
    without them they stay those of segments.
    """
    learned = asked.learned
    if not text.strip():
        raise QueryError("search: expected words, found an empty question. Say what to look for.")
    question = understand(learned, unquote(text), asked.added)
    only = () if features is None or by_symbols else only_action(unquote(text), learned)
    only = tuple(map(asked.likeliest, only))
    measured = tuple(sorted(measured_words(only) & question.unknown.keys()))
    question = without_measured(question, measured)
    words = list(dict.fromkeys(w for a in actions_of(question.tree) for w in a.all_words))
    actions, not_decoded = plain_actions(question.tree)
    if by_symbols:
        undecided = WordAnswer((), question, actions, (*question.not_used, *not_decoded))
        return _search_decoded(asked, undecided, words, allowed, limit)
    read, not_searched = readings(question.tree)
    verbs = verbs_in(text, learned.synonyms, learned.lemmas)
    asked = without_words_apart(asked, read, verbs)
    is_order = features is not None and len(read) == 1 and placing.is_order(read[0])
    measures = features is not None and len(read) == 1 and is_measured(asked, read[0], only)
    unmeasured = (
        unmeasured_words(
            asked, parse(unquote(text), learned.synonyms, learned.lemmas).tree, read, only
        )
        if features
        else ()
    )
    is_checked = is_order or measures
    n_judged = MEASURED if measures else ORDERS_LOOKED_AT if is_order else LOOKED_AT
    find_them = partial(
        find, asked, allowed=allowed, limit=max(limit, n_judged), written=written, verbs=verbs
    )
    found = find_them(read)
    place = partial(_place, asked, read, written, features, only)
    if is_checked:
        found = [_checked(each, place(each)) for each in found]
    judged = found[:n_judged]
    ranked = (
        [*sorted(judged, key=_place_in_list), *found[n_judged:]][:limit]
        if is_checked
        else found[:limit]
    )
    matches = tuple(
        _match(
            asked, rank, each, each.placed or place(each), read[each.hit.reading], words, written
        )
        for rank, each in enumerate(ranked, start=1)
    )
    once = tuple(map(without_amounts, read))  # how often and how long was never measured
    shown = judged if once == tuple(read) else find_them(once)[:n_judged]
    sure = learned.word_certainty
    unchecked = why_unchecked(asked, sorted(set().union(*map(words_of_reading, read))))
    known = sure is not None and not np.isnan(sure.threshold) and not unchecked
    threshold = sure.threshold if sure is not None and known else None
    return WordAnswer(
        tuple(map(_all_unknown, matches)) if unmeasured else matches,
        question,
        actions,
        (*question.not_used, *not_searched),
        reasons=tuple(each.why for each in ranked),
        strength=best_strength(asked, shown, threshold),
        doubtful=is_doubtful([each.sure for each in judged])
        or (is_checked and all(map(_is_weak if known else _is_contradicted, judged))),
        suggests=tuple(partial(learned.captions_like, each.capture) for each in ranked),
        threshold=threshold,
        vocabulary=asked.names,
        sources=word_sources(learned, words),
        written=asked.written_words,
        unchecked=unchecked,
        measured=measured,
        unmeasured=unmeasured,
    )


def _checked(answer: Found, placed: placing.Placed) -> Found:
    """An answer with its places; without a probability where order or motion speak against it.

    How often such an answer is right was not measured.
    """
    if placed.in_order is not False and not placed.contradicted:
        return replace(answer, placed=placed)
    return replace(answer, placed=placed, sure=replace(answer.sure, whole=None))


def _is_weak(answer: Found) -> bool:
    """Whether an answer is more likely wrong than right, or its order or motion is another."""
    if answer.placed is None or answer.placed.in_order is False or answer.placed.contradicted:
        return True
    whole = answer.sure.whole
    return reasons.total(answer.why) < 0.0 if whole is None else whole < placing.LIKELY


def _place_in_list(answer: Found) -> tuple[bool, float]:
    """Sorts answers: probable ones first; a contradiction counts as much as a caption."""
    log_odds = reasons.total(answer.why) - WRITTEN * _is_contradicted(answer)
    return _is_weak(answer), -log_odds


def _is_contradicted(answer: Found) -> bool:
    """Whether the motion of an answer contradicts the question, as measured."""
    return answer.placed is not None and bool(answer.placed.contradicted)


def _place(
    asked: AskedWords,
    read: Sequence[Reading],
    written: bool,
    features: placing.Features | None,
    only: tuple[str, ...],
    answer: Found,
) -> placing.Placed:
    """Where a capture shows the parts of an answer, by segments and then by frames."""
    reading, capture = read[answer.hit.reading], answer.capture
    places = placing.place_answer(asked, capture, answer.hit, reading, answer.sure.parts, written)
    length = asked.learned.captures[capture].motion_frames
    if features is None:
        return placing.sure_of_whole(placing.Placed(places), length)
    placed = placing.refine_places(asked, capture, reading, places, features, written)
    if len(read) == 1 and is_measured(asked, reading, only):
        placed = compare_with_motion(asked, capture, reading, placed, features, written, only)
    return placing.sure_of_whole(placed, length)


def _match(
    asked: AskedWords,
    rank: int,
    answer: Found,
    placed: placing.Placed,
    reading: Reading,
    words: Sequence[str],
    written: bool,
) -> Match:
    """One capture's answer: ranked by the word map, placed by the evidence of places."""
    learned, evidence = asked.learned, asked.evidence
    takes = evidence.takes if written else evidence.seen
    places = placed.parts
    parts = tuple(
        MatchPart(
            words,
            *to_seconds(learned, answer.capture, place.start, place.end),
            place.probability,
            place.interval_probability,
            "unknown" if place.unknown else "known",
        )
        for words, place in zip(_part_words(reading), places)
    )
    start, end = min(p.start for p in places), max(p.end for p in places)
    return Match(
        rank,
        learned.captures[answer.capture].name,
        *to_seconds(learned, answer.capture, start, end),
        float(1.0 / (1.0 + np.exp(-reasons.total(answer.why)))),
        _matched(asked, answer.capture, takes[answer.capture], words),
        "; ".join(map(_say_part, parts))
        + ("; not seen in this order" if placed.in_order is False else "")
        + "".join(f"; measured: {words}" for words in placed.contradicted)
        + mark_generated(learned, answer.capture, "; "),
        answer.sure.whole,
        placing.interval_probability(answer.sure.whole, places, reading),
        "unknown" if any(place.unknown for place in places) else "known",
        parts,
        placed.in_order,
        placed.contradicted,
    )


def unquote(text: str) -> str:
    """A question without quotation marks around it.

    >>> unquote('"walk, sit"'), unquote('walk')
    ('walk, sit', 'walk')
    """
    bare = text.strip()
    for opening, closing in QUOTES:
        if len(bare) > 1 and bare.startswith(opening) and bare.endswith(closing):
            return bare[1:-1]
    return text


def with_takings(answer: WordAnswer, takings: Mapping[str, Taking]) -> WordAnswer:
    """An answer with replaced words; it and the parts that ask for them carry no probabilities.

    Who walks may not limp: how probably an answer for "walk" shows "limp" is not known.
    """
    if not takings:
        return answer
    taken = {word: taking for word, taking in takings.items() if taking.heard}
    others = {word for word, taking in taken.items() if taking.is_other}
    matches = answer.matches
    if others:
        matches = tuple(
            replace(
                _unknown(match),
                parts=tuple(
                    part if others.isdisjoint(part.words.split()) else _unknown(part)
                    for part in match.parts
                ),
            )
            for match in matches
        )
    suggested = {word: taking for word, taking in takings.items() if not taking.heard}
    hints = hints_of(suggested)
    question, not_used = with_hints(answer.question, hints), hinted(answer.not_used, hints)
    return replace(
        answer,
        matches=tuple(replace(m, reason=with_notation(m.reason, taken)) for m in matches),
        question=question,
        not_used=not_used,
        taken=taken,
        suggested=suggested,
    )


_Certain = TypeVar("_Certain", Match, MatchPart)


def _unknown(one: _Certain) -> _Certain:
    """An answer or a part of one, without its probabilities."""
    return replace(one, probability=None, interval_probability=None)


def _all_unknown(match: Match) -> Match:
    """An answer without its probabilities and those of its parts."""
    return replace(_unknown(match), parts=tuple(map(_unknown, match.parts)))


def without_chances(
    answer: WordAnswer, missing: tuple[str, ...] = (), near: tuple[()] | tuple[str, str] = ()
) -> WordAnswer:
    """The answer to the rest of a question of which some words are missing, or to a near one."""
    matches = tuple(map(_all_unknown, answer.matches))
    return replace(
        answer, matches=matches, threshold=None, missing=missing, doubtful=False, near=near
    )


def _search_decoded(
    asked: AskedWords,
    answer: WordAnswer,
    asked_words: Sequence[str],
    allowed: Sequence[int],
    limit: int,
) -> WordAnswer:
    """An answer with the captures whose symbols are nearest to those that its actions decode to."""
    from motiondb.meaning import alignment  # compiled code, which other questions do without

    learned = asked.learned
    words = tuple(word for action in answer.actions for word in action)
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
            _matched(asked, capture, asked.evidence.takes[capture], asked_words),
            f"symbols {' '.join(str(s) for s in decoded.symbols)}{note}"
            + mark_generated(learned, capture, "; "),
        )
        for rank, (score, capture, start, end) in enumerate(answers[:limit], start=1)
    )
    return replace(answer, matches=matches, decoding=decoded)


def to_seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    """An interval of a capture in seconds, from frames [start, end) at 30 a second."""
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def _matched(
    asked: AskedWords, capture: int, take: word_evidence.TakeScores, words: Sequence[str]
) -> tuple[str, ...]:
    """Asked words that are likelier than not in the capture.

    Words whose probability no own caption has checked count only where they are written.
    """
    number = asked.numbers
    top = np.maximum(take.windows.max(axis=0), take.whole)
    said = asked.evidence.written.get(capture)
    here = asked.checked if said is None else asked.checked | (said.max(axis=0) > 0.0)
    shown = (word for word in words if top[number[word]] > 0.0 and here[number[word]])
    return tuple(map(as_said, shown))


def mark_generated(learned: Learned, capture: int, before: str = "") -> str:
    """The word "generated" for a generated capture, otherwise nothing."""
    return f"{before}generated" if learned.captures[capture].kind == "generated" else ""


def _part_words(reading: Reading) -> list[str]:
    """The actions of every part of a reading."""
    said = []
    for k, part in enumerate(reading.parts):
        asked = [" ".join(map(as_said, action)) for action in part.actions]
        only = [e for e in reading.exclusions if (e.first, e.last) == (k, k + 1)]
        excluded = [
            f"not {' and '.join(' '.join(map(as_said, a)) for a in e.actions)}" for e in only
        ]
        joined = "".join(
            text if n == 0 else f" {text}" if manner_of(text) else f" while {text}"
            for n, text in enumerate(asked)
        )
        said.append(joined or ", ".join(excluded) or "?")
    return said


def _say_part(part: MatchPart) -> str:
    """A part of an answer with its interval, or that its place is unknown."""
    if part.place == "unknown":
        return f"{part.words} somewhere in {part.start:g}-{part.end:.1f} s, by its caption"
    return f"{part.words} {part.start:.2f}-{part.end:.2f} s"
