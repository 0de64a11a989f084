"""Certainty of an answer to words, as a whole and for each part; whether anything matches at all.

Only probabilities that were learned from questions of the same kind are given. These kinds are

    actions asked for, in order or at once; exclusions alone:
        the product of the probabilities of the statements (``regression.answer_probability``),
    one action but not another; one of several actions:
        learned separately (:mod:`motiondb.meaning.asked_certainty`).

No probability is given where a word of the question is known from a start alone, so that no own
caption has checked it (:mod:`motiondb.learn.checking`).

There is no probability for orders that are not seen (``by_words``), for repeats and durations, for
orders with exclusions, for several exclusions with an action, and for alternatives of more than one
action: how often such answers are right was never measured.

Every action of a question has a *strength*: nats by which it is more probable than usual for its
words. Below a threshold, which was learned from questions without a right answer
(:mod:`motiondb.meaning.regression`), nothing matches. Above it, it is doubtful whether anything
does if some action has a probability below one half by each of the first answers, or the only one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import prod

import numpy as np

from motiondb.language.question.readings import Reading
from motiondb.learn.checking import say_unchecked
from motiondb.learn.joining import start_weight
from motiondb.learn.learned import Learned
from motiondb.meaning import regression
from motiondb.meaning.by_question import QuestionHit, Statement
from motiondb.meaning.regression import KindCertainty, kind_cues
from motiondb.meaning.word_evidence import action_log_odds
from motiondb.meaning.word_map import usual
from motiondb.records import Match
from motiondb.search.asked_words import AskedWords
from motiondb.search.reasons import said_by_captions

LIKELY = 0.5  # Probability above which a statement is more likely true than not
SURE = 1.0 - 1e-12  # Largest probability of a condition, so that its log-odds are finite


@dataclass(frozen=True)
class PartChance:
    """Certainty that a capture shows a part of a question."""

    # Probability with the evidence of captions; None if own captions have not checked it
    probability: float | None
    # Probability by the motion alone; not calibrated where ``probability`` is None
    by_motion: float
    by_caption: bool  # Whether captions have the words of the part


@dataclass(frozen=True)
class Chances:
    """Certainty of an answer, given for some kinds of questions (see the module)."""

    # Probability that the capture shows all requested actions and no excluded one; None if it is
    # not known
    whole: float | None
    # Certainty of every part of the reading; None if the part asks for nothing, or it is not known
    parts: tuple[PartChance | None, ...]
    actions: tuple[float, ...] = ()  # Probability of every requested action; () if not known


@dataclass(frozen=True, eq=False)
class Found:
    """One capture's answer: its interval and its certainty."""

    capture: int
    hit: QuestionHit
    certain: Callable[[int, QuestionHit], Chances]

    @cached_property
    def sure(self) -> Chances:
        """Its certainty, which is computed where it is looked at."""
        return self.certain(self.capture, self.hit)


def chances(
    asked: AskedWords,
    readings: Sequence[Reading],
    is_checked: bool,
    capture: int,
    hit: QuestionHit,
) -> Chances:
    """Certainty of an answer to the readings of a question; `is_checked`: ``are_checked``."""
    reading, kinds = readings[hit.reading], asked.learned.certainties
    unknown = Chances(None, (None,) * len(reading.parts))
    if any(map(counts_or_lasts, readings)):
        return unknown
    sure = asked.learned.word_certainty
    if is_checked and sure is None:
        return unknown
    stated = _with_captions(asked, capture, hit.statements, sure if is_checked else None)
    requested = [each for each in stated if each.statement.exclusion < 0]
    parts = _of_parts(is_checked, reading, requested)
    if not is_checked:
        return Chances(None, parts)
    numbers = sorted({s.exclusion for s in hit.statements if s.exclusion >= 0})
    excluded = [[e for e in stated if e.statement.exclusion == n] for n in numbers]
    said = all(each.is_said for each in requested)
    if len(readings) > 1:
        if not all(map(is_one_action, readings)):
            asked_for = {frozenset(a for p in r.parts for a in p.actions) for r in readings}
            same = len(asked_for) == 1 and not excluded
            actions = tuple(each.probability for each in requested) if same else ()
            return replace(unknown, actions=actions)
        return chances_of_kind(kinds.either, requested[0].odds, None, said)
    if requested and excluded:
        if not len(requested) == len(excluded) == len(excluded[0]) == len(reading.parts) == 1:
            return unknown
        return chances_of_kind(kinds.without, requested[0].odds, excluded[0][0].odds, said)
    each_action = tuple(each.probability for each in requested)
    whole = regression.answer_probability(
        each_action, [[each.probability for each in of] for of in excluded]
    )
    return Chances(whole, parts, each_action)


@dataclass(frozen=True)
class _Stated:
    """A statement, and what captions add to it."""

    statement: Statement
    said: float  # The part of its log-odds that captions add, which is not calibrated
    is_said: bool  # Whether captions have all of its words
    by_motion: float  # The rest of its log-odds; calibrated where the words are checked

    @property
    def odds(self) -> tuple[float, float]:
        """Its log-odds before they are calibrated, and the part that captions add."""
        return self.statement.log_odds, self.said

    @property
    def probability(self) -> float:
        """The probability that it holds."""
        return _probability(self.by_motion + self.said)


def _with_captions(
    asked: AskedWords,
    capture: int,
    statements: Sequence[Statement],
    sure: regression.Certainty | None,
) -> list[_Stated]:
    """Statements about a capture, with what captions of the capture add to them."""
    written = asked.evidence.written.get(capture)
    log_odds, is_said = [each.log_odds for each in statements], [False] * len(statements)
    by_motion = log_odds.copy()
    if written is not None:
        starts = asked.learned.segments.starts[asked.learned.rows[capture]]
        for n, each in enumerate(statements):
            of_words = [said_by_captions(written[:, word], starts, each) for word in each.words]
            is_said[n] = min(of_words) > 0.0
            by_motion[n] = float(
                action_log_odds([every - of for every, of in zip(each.odds, of_words)])
            )
    said = [every - alone for every, alone in zip(log_odds, by_motion)]
    if sure is not None:
        (weight,) = sure.weights.tolist()
        by_motion = [weight * each + sure.constant for each in by_motion]
    return list(map(_Stated, statements, said, is_said, by_motion))


def counts_or_lasts(reading: Reading) -> bool:
    """Return whether a reading asks for repeats or durations."""
    return any(
        part.seconds > 0.0
        or part.repeat_of != k
        or part.least > 1
        or not (part.most is None and part.longest is None)
        for k, part in enumerate(reading.parts)
    )


def is_one_action(reading: Reading) -> bool:
    """Whether a reading is one action without exclusions."""
    return len(reading.parts) == 1 and len(reading.parts[0].actions) == 1 and not reading.exclusions


def chances_of_kind(
    kind: KindCertainty,
    asked: tuple[float, float],
    excluded: tuple[float, float] | None,
    by_caption: bool = False,
) -> Chances:
    """Chances of "a but not b", or of the best alternative of "a or b" (nothing excluded).

    P(not b | a) is P(a and not b) / P(a) by the motion. The evidence of captions is added to the
    log-odds of a and of b; it is not calibrated.
    """
    if kind.whole is None or kind.part is None:
        return Chances(None, (None,))
    cues = kind_cues(asked[0] - asked[1], None if excluded is None else excluded[0] - excluded[1])
    whole, part = float(kind.whole.log_odds(cues)), float(kind.part.log_odds(cues))
    if excluded is None:
        part = min(part, whole)  # one of the alternatives is shown where the best one is
        all_of_it = _probability(whole + asked[1])
    else:
        free = min(_probability(whole) / _probability(part), SURE)
        log_odds = float(np.log(free) - np.log1p(-free)) - excluded[1]
        all_of_it = _probability(part + asked[1]) * _probability(log_odds)
    of_part = PartChance(_probability(part + asked[1]), _probability(part), by_caption)
    return Chances(all_of_it, (of_part,))


def _of_parts(
    is_checked: bool, reading: Reading, requested: Sequence[_Stated]
) -> tuple[PartChance | None, ...]:
    """The certainty that a capture shows each part."""
    parts: list[PartChance | None] = []
    for k, part in enumerate(reading.parts):
        of_part = [each for each in requested if each.statement.part == k]
        if not part.actions or not of_part:
            parts.append(None)
            continue
        chance = prod(each.probability for each in of_part) if is_checked else None
        by_motion = prod(_probability(each.by_motion) for each in of_part)
        parts.append(PartChance(chance, by_motion, all(each.is_said for each in of_part)))
    return tuple(parts)


def _probability(log_odds: float) -> float:
    """As ``regression.probability``, of one number."""
    return 1.0 / (1.0 + math.exp(-min(max(log_odds, -50.0), 50.0)))


@dataclass(frozen=True)
class WordSource:
    """The captions from which a word was learned, in a database that learned with a start.

    Attributes
    ----------
    word : str
        The word.
    start : str
        Name of the start.
    start_captions : int
        Captions of the start that hold the word.
    own_captions : int
        Own captions that hold it.
    weight : float
        Weight of a caption of the start relative to an own one; 1 if no own caption has the word,
        because it is then learned from the start alone.
    """

    word: str
    start: str
    start_captions: int
    own_captions: int
    weight: float

    def sentence(self) -> str:
        """The sentence for the user.

        >>> WordSource("walk", "cmu", 74, 0, 1.0).sentence()
        'walk: known from the start cmu alone (74 captions there)'
        >>> WordSource("walk", "cmu", 74, 1, 0.5).sentence()
        'walk: known from 1 own caption and 74 of the start cmu, each of which counts 0.5'
        >>> WordSource("dash", "cmu", 0, 3, 0.5).sentence()
        'dash: known from 3 own captions alone'
        """
        captions = f"{self.own_captions} own caption{'' if self.own_captions == 1 else 's'}"
        if not self.own_captions:
            start_captions = (
                "1 caption" if self.start_captions == 1 else f"{self.start_captions} captions"
            )
            return f"{self.word}: known from the start {self.start} alone ({start_captions} there)"
        if not self.start_captions:
            return f"{self.word}: known from {captions} alone"
        return (
            f"{self.word}: known from {captions} and {self.start_captions} of the start "
            f"{self.start}, each of which counts {self.weight:.2g}"
        )


def word_sources(learned: Learned, words: Iterable[str]) -> tuple[WordSource, ...]:
    """The captions from which some words were learned; empty without a start.

    Words that were not learned are left out.
    """
    started = learned.started
    if started is None:
        return ()
    counts = learned.counted.counts
    captions_of = dict(zip(learned.counted.reference.association.words, counts.said.tolist()))
    weight = start_weight(counts.moments.n)
    sources = []
    for word in dict.fromkeys(words):
        in_start, in_own = started.said.get(word, 0), captions_of.get(word, 0)
        if in_start or in_own:
            name = started.knowledge.origin.name
            sources.append(WordSource(word, name, in_start, in_own, weight if in_own else 1.0))
    return tuple(sources)


def why_unchecked(asked: AskedWords, words: Iterable[str]) -> str:
    """The reason why answers about some words carry no probabilities; "" where they do."""
    learned = asked.learned
    number = asked.numbers
    unsure = [w for w in dict.fromkeys(words) if w in number and not asked.checked[number[w]]]
    if not unsure and learned.word_certainty is not None:
        return ""
    return say_unchecked(learned.counted.counts.moments.n, unsure, learned.word_certainty)


NOTHING = "nothing in this database matches"


def reaches(
    matches: Sequence[Match], strength: float | None, threshold: float | None
) -> bool | None:
    """Whether a best match is good enough; None if no threshold was learned."""
    if not matches:
        return False
    return None if strength is None or threshold is None else strength >= threshold


def best_strength(
    asked: AskedWords, hits: Sequence[QuestionHit], threshold: float | None
) -> float | None:
    """Nats by which the least certain action of a question is more probable than usual.

    Of every action, the answer counts that shows it best: a question of which every action is
    shown, but by different captures, is not called absent. With exclusions, the best answer as a
    whole counts. None if there are no answers.
    """
    best: dict[int, dict[tuple[int, ...], float]] = {}
    usual_odds = usual(asked.word_map)
    usually = cache(lambda words: float(action_log_odds(usual_odds[list(words)])))
    for hit in hits:
        of_reading = best.setdefault(hit.reading, {})
        whole = any(statement.exclusion >= 0 for statement in hit.statements)
        for action in [()] if whole else dict.fromkeys(s.words for s in hit.statements):
            stated = [
                (statement.exclusion, statement.log_odds - usually(statement.words))
                for statement in hit.statements
                if whole or statement.words == action
            ]
            clear = _strength(stated, threshold)
            of_reading[action] = max(clear, of_reading.get(action, clear))
    return max((min(parts.values()) for parts in best.values() if parts), default=None)


def _strength(stated: Sequence[tuple[int, float]], threshold: float | None) -> float:
    """Nats by which the least certain of some statements is more probable than usual.

    `stated`: The number of the exclusion (-1: none) and these nats of each. For an excluded action,
    the distance to the threshold changes its sign: a motion without the action matches if the
    action itself would not.
    """
    clear = [over for exclusion, over in stated if exclusion < 0]
    if threshold is not None:
        for number in {n for n, _ in stated if n >= 0}:
            clear.append(2.0 * threshold - min(over for n, over in stated if n == number))
    return min(clear, default=0.0)


def is_unlikely(wholes: Iterable[float | None], replaced: float = 1.0) -> bool:
    """Whether each answer is more likely wrong than right.

    `wholes`: The probability of each answer, looked at up to the first one that is likely.
    `replaced`: Probability that words of the question may be replaced as they are.

    >>> is_unlikely([0.6]), is_unlikely([0.6], 0.8), is_unlikely([None])
    (False, True, False)
    """
    is_known = False
    for whole in wholes:
        if whole is not None and replaced * whole >= LIKELY:
            return False
        is_known = is_known or whole is not None
    return is_known


def lacking_actions(actions: Iterable[Sequence[float]]) -> set[int]:
    """The numbers of the actions that no answer shows.

    `actions`: Of each answer, their probabilities; looked at until each action is shown.

    >>> lacking_actions([(0.9, 0.1), (0.2, 0.8)]), lacking_actions([(0.9, 0.1), (0.8, 0.2)])
    (set(), {1})
    """
    lacking: set[int] | None = None
    n = None
    for of in actions:
        n = len(of) if n is None else n
        if of and len(of) == n:
            lacking = {*range(n)} if lacking is None else lacking
            lacking = {k for k in lacking if of[k] < LIKELY}
            if not lacking:
                return set()
    return lacking or set()
