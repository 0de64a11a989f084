"""How well a database that learned from some captures answers about others.

The captures in question must have captions, which only judge: they are no evidence here. They are
cut and scored by the learned symbols, as a generated capture is, and searched among themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np

from motiondb import store
from motiondb.answers.database import Evaluation, Score, WordScore
from motiondb.answers.plain import extended
from motiondb.body.features import recognition_features
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.language.vocabulary import MODIFIERS, words_of
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.recognition import FramePool, frame_rows, recognise_capture
from motiondb.meaning.counting import join_tables
from motiondb.meaning.occurrences import measured_track
from motiondb.records import Caption, CaptureInfo, Float32Array, Match, Motion, SegmentTable
from motiondb.search.asking import understand_learned
from motiondb.search.by_example import search_motion
from motiondb.search.by_words import search_words
from motiondb.search.described import describe
from motiondb.search.seen_frames import Frames
from motiondb.workers import Workers, runs

Item = TypeVar("Item")
Result = TypeVar("Result")
Tell = Callable[[str, float], None]
LIKELY = 0.5  # Probability from which on a word is said of a capture
HALF = 0.5  # Overlap of two intervals from which on they count as the same


@dataclass(frozen=True, eq=False)
class _Held:
    """The captures in question, and the model that sees them."""

    pool: FramePool  # Frames of the captures in question
    learned: Learned  # With segments of the captures in question, and without their captions
    infos: tuple[CaptureInfo, ...]
    captions: dict[int, tuple[Caption, ...]]
    said: dict[int, frozenset[str]]  # Capture -> words of its captions
    motions: dict[int, Motion]

    @cached_property
    def frames(self) -> Frames:
        """What questions look at in the captures."""
        return Frames(self.pool, lambda number: measured_track(self.motions[number]))

    @property
    def numbers(self) -> list[int]:
        """Numbers of the captures."""
        return [info.capture_id for info in self.infos]

    def in_order(self, matches: Sequence[Match], allowed: Sequence[int]) -> list[int]:
        """Numbers in the order of matches; those that were not found come last."""
        by_name = {info.name: info.capture_id for info in self.infos}
        found = list(dict.fromkeys(by_name[match.capture] for match in matches))
        return found + [number for number in allowed if number not in set(found)]


@dataclass(frozen=True, eq=False)
class _Asking:
    """Who answers the questions."""

    held: _Held
    workers: Workers

    def each(
        self, ask: Callable[[Item, _Held], Result], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Result]]:
        """Items with the answer to the question about each, in their order."""
        every = list(items)
        pieces = runs(every, self.workers.n_pieces())
        answers = self.workers.map(_ask_some, pieces, ask, self.held)
        yield from zip(every, (answer for part in answers for answer in part))


def _ask_some(
    items: Sequence[Item], ask: Callable[[Item, _Held], Result], held: _Held
) -> list[Result]:
    """Answers about some items."""
    return [ask(item, held) for item in items]


def evaluate(session: Session, where: str, tell: Tell, workers: Workers) -> Evaluation:
    """Score words, captions, examples, intervals and descriptions of other captures."""
    with session.reading():
        held = _load(session, where, workers)
        asking = _Asking(held, workers)
        tell("words", 0.0)
        words = _words(asking)
        tell("captions", 0.3)
        values, chances = [w.average_precision for w in words], [w.chance for w in words]
        scores = [_score("words", "mean average precision", values, chances), *_captions(asking)]
        tell("examples", 0.5)
        scores += _examples(asking)
        tell("intervals", 0.8)
        scores += [*_intervals(asking), *_descriptions(asking)]
        tell("intervals", 1.0)
        n_learned = len(session.learned.rows)
        return Evaluation(where, n_learned, len(held.infos), tuple(scores), tuple(words))


def _load(session: Session, where: str, workers: Workers) -> _Held:
    """Load the captures in question, which must not have been learned from."""
    opened, learned = session.store, session.learned
    infos = [i for i in store.load_captures(opened, where) if i.is_captured]
    known = [info.name for info in infos if info.capture_id in learned.rows]
    if known:
        raise QueryError(
            "evaluate: expected captures that the database has not learned from, found "
            f"{len(known)} that it has, such as {known[0]}. Learn from the others: motiondb learn "
            f"--where 'not ({where or 'FILTER'})'."
        )
    captions = store.load_captions(opened)
    said = {
        info.capture_id: frozenset(
            word
            for caption in captions.get(info.capture_id, ())
            for word in words_of(caption.words, learned.synonyms, learned.lemmas)
        )
        for info in infos
    }
    infos = [info for info in infos if said[info.capture_id]]
    if len(infos) < 2:
        raise QueryError(
            "evaluate: expected two or more captures with captions that match, found "
            f"{len(infos)}. Give another filter with --where."
        )
    motions = {i.capture_id: store.load_motion(opened, i.capture_id) for i in infos}
    pieces = runs(list(motions.items()), workers.n_pieces())
    cut = workers.map(_recognise_some, pieces, extended(LearnedModel, learned))
    tables = [table for part in cut for table in part]
    seen = replace(
        learned,
        segments=join_tables(learned.segments, *tables),
        captions={n: c for n, c in learned.captions.items() if n not in said},
    )
    own = {info.capture_id: captions[info.capture_id] for info in infos}
    features_of = partial(_features, motions)
    rows = [frame_rows(learned, features_of(number)) for number in motions]
    numbers, bounds = np.array(list(motions)), np.cumsum([0, *map(len, rows)])
    pool = FramePool(numbers, bounds, np.concatenate(rows), features_of)
    return _Held(pool, seen, tuple(infos), own, said, motions)


def _features(motions: Mapping[int, Motion], number: int) -> Float32Array:
    """Recognition features of one of some captures."""
    return recognition_features(motions[number])


def _recognise_some(
    motions: Sequence[tuple[int, Motion]], learned: LearnedModel
) -> list[SegmentTable]:
    """Segments of some captures."""
    return [recognise_capture(learned, number, motion) for number, motion in motions]


def _ranked(text: str, held: _Held) -> list[int] | None:
    """The captures, best first, for words, by their motion alone; None if no word is known."""
    try:
        question = understand_learned(held.learned, text)
        answer = search_words(question, held.numbers, len(held.infos), written=False)
    except QueryError:  # such as a word of the language of questions
        return None
    return held.in_order(answer.matches, held.numbers)


def _words(asking: _Asking) -> list[WordScore]:
    """Average precision of every learned word that some of the captures show, and not all."""
    held, shown = asking.held, dict[str, set[int]]()
    for word in held.learned.association.words:
        right = {number for number, words in held.said.items() if word in words}
        if 0 < len(right) < len(held.infos):
            shown[word] = right
    return [
        WordScore(
            word,
            len(shown[word]),
            average_precision(ranked, shown[word]),
            len(shown[word]) / len(held.infos),
        )
        for word, ranked in asking.each(_ranked, shown)
        if ranked is not None
    ]


def average_precision(ranked: Sequence[int], right: set[int] | frozenset[int]) -> float:
    """Mean of the precision at every right answer of a ranking.

    >>> average_precision([7, 3, 5], {7, 5})
    0.8333333333333333
    """
    places = [place for place, number in enumerate(ranked, start=1) if number in right]
    return sum(n / place for n, place in enumerate(places, start=1)) / len(right)


def _captions(asking: _Asking) -> list[Score]:
    """How early a capture is found by its own caption, or by one with the same words."""
    held, reciprocal, first, chance = asking.held, list[float](), list[float](), list[float]()
    learned = held.learned
    whole = [
        (number, caption.words)
        for number, captions in held.captions.items()
        for caption in captions
        if caption.start is None and caption.end is None
    ]
    answered = asking.each(_ranked, (text for _, text in whole))
    for number, (text, ranked) in zip((number for number, _ in whole), answered):
        if ranked is None:
            continue
        words = frozenset(words_of(text, learned.synonyms, learned.lemmas))
        right = {n for n, said in held.said.items() if words <= said} | {number}
        place = min(ranked.index(n) for n in right) + 1
        reciprocal.append(1.0 / place)
        first.append(float(place == 1))
        chance.append(len(right) / len(held.infos))
    return [
        _score("captions", "mean reciprocal rank", reciprocal),
        _score("captions", "found first", first, chance),
    ]


def _examples(asking: _Asking) -> list[Score]:
    """How early captures that share an action word with an example are found by its motion."""
    precision, first, chance = [], [], []
    actions = {number: words - MODIFIERS for number, words in asking.held.said.items()}
    shared = {
        number: {n for n, others in actions.items() if n != number and words & others}
        for number, words in actions.items()
    }
    asked = (number for number, right in shared.items() if right)
    for number, ranked in asking.each(_alike, asked):
        right = shared[number]
        precision.append(average_precision(ranked, right))
        first.append(float(ranked[0] in right))
        chance.append(len(right) / (len(shared) - 1))
    return [
        _score("examples", "mean average precision", precision, chance),
        _score("examples", "best answer right", first, chance),
    ]


def _alike(number: int, held: _Held) -> list[int]:
    """The other captures, best first, by the motion of one."""
    allowed = [other for other in held.numbers if other != number]
    motion = held.motions[number]
    answer = search_motion(held.learned, held.frames, motion, allowed, len(allowed))
    return held.in_order(answer.matches, allowed)


def _intervals(asking: _Asking) -> list[Score]:
    """How far the interval that is found in a capture overlaps with that of a timed caption."""
    timed = [
        (info, caption)
        for info in asking.held.infos
        for caption in asking.held.captions[info.capture_id]
        if caption.start is not None or caption.end is not None
    ]
    found = (overlap for _, overlap in asking.each(_overlap_of, timed))
    overlaps = [overlap for overlap in found if overlap is not None]
    return [
        _score("intervals", "mean overlap", overlaps),
        _score("intervals", f"overlap of {HALF:g} or more", [float(o >= HALF) for o in overlaps]),
    ]


def _overlap_of(timed: tuple[CaptureInfo, Caption], held: _Held) -> float | None:
    """Overlap of a caption's interval with the one found; None if no word of it is known."""
    info, caption = timed
    try:
        question = understand_learned(held.learned, caption.words, looks_at_motion=True)
        answer = search_words(question, [info.capture_id], 1, written=False, frames=held.frames)
    except QueryError:
        return None
    if not answer.matches:
        return 0.0
    end = info.duration if caption.end is None else caption.end
    return _overlap(answer.matches[0].start, answer.matches[0].end, caption.start or 0.0, end)


def _overlap(start: float, end: float, low: float, high: float) -> float:
    """Intersection of two intervals (seconds) over their union.

    >>> _overlap(0.0, 2.0, 1.0, 3.0)
    0.3333333333333333
    """
    common = max(0.0, min(end, high) - max(start, low))
    return common / (max(end, high) - min(start, low))


def _told(number: int, held: _Held) -> set[str]:
    """Words that the motion of a capture is described by."""
    told = describe(held.learned, held.motions[number])
    return {w for d in told for w, p in d.words if p is not None and p >= LIKELY}


def _descriptions(asking: _Asking) -> list[Score]:
    """Precision and recall of the words that the motion of captures is described by."""
    held = asking.held
    known = set(held.learned.association.words)
    precision, recall = [], []
    for number, likely in asking.each(_told, held.motions):
        right = held.said[number] & known
        if likely:
            precision.append(len(likely & right) / len(likely))
        if right:
            recall.append(len(likely & right) / len(right))
    return [
        _score("descriptions", "precision of words", precision),
        _score("descriptions", "recall of words", recall),
    ]


def _score(task: str, measure: str, values: Sequence[float], chance: Sequence[float] = ()) -> Score:
    """A mean over questions; without any, None."""
    return Score(
        task,
        measure,
        len(values),
        float(np.mean(values)) if values else None,
        float(np.mean(chance)) if chance else None,
    )
