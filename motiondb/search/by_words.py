"""Search by words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from motiondb.errors import QueryError
from motiondb.language.question.known import KnownQuestion, hinted, with_hints
from motiondb.language.question.manner import manner_of
from motiondb.language.question.readings import Reading
from motiondb.language.question.say import plain_actions
from motiondb.language.question.tree import NotUsed, actions_of
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import decode, understand
from motiondb.meaning import by_words
from motiondb.records import MOTION_FPS, Match, MatchPart
from motiondb.search import placing, ranking, reasons
from motiondb.search.asked_words import AskedWords, WrittenWord
from motiondb.search.chances import WordSource, why_unchecked, word_sources, words_of_reading
from motiondb.search.explained_answer import Explanation, explain
from motiondb.search.unknown_words import Taking, hints_of

MOST_DECODED = 50
"""Largest number of words that are decoded to symbols at once: 200 words need 2 GB, and
sequences are short."""


QUOTES = (('"', '"'), ("\u201c", "\u201d"), ("\u201e", "\u201c"))
"""Pairs of quotation marks around a caption."""


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
        Of the best match: nats by which its least certain action is more probable than usual for
        these words.
    threshold : float or None
        Strength below which nothing in the database matches; None if it could not be learned
        (``meaning.calibration``).
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

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Per match the parts of the log-odds that rank it; none for a search by symbols."""
        return tuple(explain(why, self.vocabulary) for why in self.reasons)

    @property
    def unknown(self) -> Mapping[str, tuple[str, ...]]:
        """Word of the question that is not known -> nearest known words."""
        return self.question.unknown

    @property
    def matches_anything(self) -> bool | None:
        """Whether anything in the database shows the requested actions; None if unknown."""
        return reaches(self.matches, self.strength, self.threshold)


def reaches(
    matches: Sequence[Match], strength: float | None, threshold: float | None
) -> bool | None:
    """Whether a best match is good enough; None if no threshold was learned."""
    if not matches:
        return False
    return None if strength is None or threshold is None else strength >= threshold


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
    allowed = [capture for capture in allowed if capture in learned.rows]
    if not text.strip():
        raise QueryError("search: expected words, found an empty question. Say what to look for.")
    text, as_caption = unquote(text)
    question = understand(learned, text, asked.added)
    if by_symbols:
        return _search_decoded(asked, question, allowed, limit)
    ranked, read, left_out = ranking.find(asked, question, allowed, limit, written, as_caption)
    matches = tuple(
        _match(asked, rank, each, read[each.hit.reading], question, written, features)
        for rank, each in enumerate(ranked, start=1)
    )
    sure = learned.word_certainty
    unchecked = why_unchecked(asked, sorted(set().union(*map(words_of_reading, read))))
    known = sure is not None and not np.isnan(sure.threshold) and not unchecked
    threshold = sure.threshold if sure is not None and known else None
    return WordAnswer(
        matches,
        question,
        plain_actions(question.tree)[0],
        (*question.not_used, *left_out),
        reasons=tuple(each.why for each in ranked),
        strength=max(
            (ranking.strength(asked, each.why, threshold) for each in ranked),
            default=None,
        ),
        threshold=threshold,
        vocabulary=asked.names,
        sources=word_sources(learned, _asked_words(question)),
        written=asked.written_words,
        unchecked=unchecked,
    )


def _asked_words(question: KnownQuestion) -> list[str]:
    return [word for action in actions_of(question.tree) for word in action.all_words]


def _match(
    asked: AskedWords,
    rank: int,
    answer: ranking.Found,
    reading: Reading,
    question: KnownQuestion,
    written: bool,
    features: placing.Features | None,
) -> Match:
    """One capture's answer: ranked by the word map, placed by the evidence of places."""
    learned, takes = asked.learned, asked.takes if written else asked.seen_takes
    places = placing.place_answer(
        asked, answer.capture, answer.hit, reading, answer.sure.parts, written
    )
    if features is not None:
        places = placing.refine_places(asked, answer.capture, reading, places, features, written)
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
        _matched(asked, answer.capture, takes[answer.capture], question),
        "; ".join(map(_say_part, parts)) + mark_generated(learned, answer.capture, "; "),
        answer.sure.whole,
        placing.interval_probability(answer.sure.whole, places, reading),
        "unknown" if any(place.unknown for place in places) else "known",
        parts,
    )


def unquote(text: str) -> tuple[str, bool]:
    """A question without quotation marks around it, and whether it had them.

    >>> unquote('"walk, sit"'), unquote('walk')
    (('walk, sit', True), ('walk', False))
    """
    bare = text.strip()
    for opening, closing in QUOTES:
        if len(bare) > 1 and bare.startswith(opening) and bare.endswith(closing):
            return bare[1:-1], True
    return text, False


def with_takings(answer: WordAnswer, takings: Mapping[str, Taking]) -> WordAnswer:
    """An answer with replaced words, with a correspondingly lower certainty.

    The probability of every match is multiplied by that of every taking.
    """
    taken = {word: taking for word, taking in takings.items() if taking.is_taken}
    share = float(np.prod([taking.probability for taking in taken.values()]))
    matches = tuple(
        match
        if match.probability is None
        else replace(
            match,
            probability=share * match.probability,
            interval_probability=_times(match.interval_probability, share),
            parts=tuple(
                replace(
                    part,
                    probability=_times(part.probability, share),
                    interval_probability=_times(part.interval_probability, share),
                )
                for part in match.parts
            ),
        )
        for match in answer.matches
    )
    suggested = {word: taking for word, taking in takings.items() if not taking.is_taken}
    hints = hints_of(suggested)
    question, not_used = with_hints(answer.question, hints), hinted(answer.not_used, hints)
    return replace(
        answer,
        matches=matches,
        question=question,
        not_used=not_used,
        taken=taken,
        suggested=suggested,
    )


def _times(probability: float | None, share: float) -> float | None:
    return None if probability is None else share * probability


def _search_decoded(
    asked: AskedWords, question: KnownQuestion, allowed: Sequence[int], limit: int
) -> WordAnswer:
    from motiondb.meaning import alignment  # compiled code, which other questions do without

    learned = asked.learned
    actions, left_out = plain_actions(question.tree)
    not_used = (*question.not_used, *left_out)
    words = tuple(word for action in actions for word in action)
    if len(words) > MOST_DECODED:
        raise QueryError(
            f"search --by-symbols: expected at most {MOST_DECODED} words, found {len(words)}. "
            "Ask for fewer actions, or leave out --by-symbols."
        )
    decoded = decode(learned, words)
    if decoded is None:
        return WordAnswer((), question, actions, not_used)
    symbols = np.array(decoded.symbols)
    weights = np.full(len(symbols), 1.0 / len(symbols))
    scale = alignment.distance_scale(learned.distances)
    answers = []
    for capture in allowed:
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
            _matched(asked, capture, asked.takes[capture], question),
            f"symbols {' '.join(str(s) for s in decoded.symbols)}{note}"
            + mark_generated(learned, capture, "; "),
        )
        for rank, (score, capture, start, end) in enumerate(answers[:limit], start=1)
    )
    return WordAnswer(matches, question, actions, not_used, decoded)


def to_seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    """An interval of a capture in seconds, from frames [start, end) at 30 a second."""
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def _matched(
    asked: AskedWords, capture: int, take: by_words.TakeScores, question: KnownQuestion
) -> tuple[str, ...]:
    """Asked words that are likelier than not in the capture.

    Words whose probability no own caption has checked count only where they are written.
    """
    words, number = dict.fromkeys(_asked_words(question)), asked.numbers
    top = np.maximum(take.windows.max(axis=0), take.whole)
    said = asked.written(capture)
    here = asked.checked if said is None else asked.checked | (said.max(axis=0) > 0.0)
    return tuple(word for word in words if top[number[word]] > 0.0 and here[number[word]])


def mark_generated(learned: Learned, capture: int, before: str = "") -> str:
    """The word "generated" for a generated capture, otherwise nothing."""
    return f"{before}generated" if learned.captures[capture].kind == "generated" else ""


def _part_words(reading: Reading) -> list[str]:
    """The actions of every part of a reading."""
    said = []
    for k, part in enumerate(reading.parts):
        asked = [" ".join(action) for action in part.actions]
        only = [e for e in reading.exclusions if (e.first, e.last) == (k, k + 1)]
        excluded = [f"not {' and '.join(map(' '.join, e.actions))}" for e in only]
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
