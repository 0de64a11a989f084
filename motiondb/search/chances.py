"""Certainty of an answer to words, as a whole and for each part; why some words have none.

Only probabilities that were learned from questions of the same kind are given. These kinds are

    actions asked for, in order or at once; exclusions alone:
        the product of the probabilities of the statements (``regression.answer_probability``),
    one action but not another; one of several actions:
        learned separately (:mod:`motiondb.meaning.asked_certainty`).

No probability is given where a word of the question is known from a start alone, so that no own
caption has checked it (:mod:`motiondb.learn.checking`).

There is no probability for repeats and durations, for orders with exclusions, for several
exclusions with an action, and for alternatives of more than one action: how often such answers are
right was never measured.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from motiondb.language.question.readings import Reading
from motiondb.learn.checking import say_unchecked
from motiondb.learn.joining import start_weight
from motiondb.learn.learned import Learned
from motiondb.meaning import regression
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.regression import KindCertainty, kind_cues
from motiondb.search import reasons
from motiondb.search.asked_words import AskedWords

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
    """Certainty of an answer."""

    # Probability that the capture shows all requested actions and no excluded one; None if it is
    # not known
    whole: float | None
    # Certainty of every part of the reading; None if the part asks for nothing, or it is not known
    parts: tuple[PartChance | None, ...]


@dataclass(frozen=True)
class QuestionCertainty:
    """What is known about the certainty of answers to one question."""

    sure: regression.Certainty | None  # Of an action
    kinds: regression.Certainties  # Of other kinds of questions
    checked: bool  # Whether own captions have checked the probabilities of all words


def question_certainty(asked: AskedWords, readings: Sequence[Reading]) -> QuestionCertainty:
    """What is known about the certainty of answers to the readings of a question."""
    learned, number = asked.learned, asked.numbers
    words = {word for reading in readings for word in words_of_reading(reading)}
    checked = all(asked.checked[number[word]] for word in words if word in number)
    return QuestionCertainty(learned.word_certainty, learned.certainties, checked)


def chances(
    known: QuestionCertainty,
    readings: Sequence[Reading],
    hit: QuestionHit,
    why: Sequence[reasons.WordReason],
) -> Chances:
    """Certainty of an answer."""
    reading, sure, kinds = readings[hit.reading], known.sure, known.kinds
    unknown = Chances(None, (None,) * len(reading.parts))
    if any(map(counts_or_lasts, readings)):
        return unknown
    if not known.checked:
        return Chances(
            None,
            tuple(
                _of_part(None, hit, reading, k, why, reasons.by_action(why))
                for k in range(len(reading.parts))
            ),
        )
    if sure is None:
        return unknown
    excluded = [lowering.actions for lowering in reasons.lowerings(why)]
    requested = reasons.by_action(why)
    said = all(reason.written > 0.0 for reason in why if reason.exclusion < 0)
    if len(readings) > 1:
        if not all(map(_is_one_action, readings)):
            return unknown
        return chances_of_kind(kinds.either, requested[0], None, said)
    if requested and excluded:
        if not len(requested) == len(excluded) == len(excluded[0]) == len(reading.parts) == 1:
            return unknown
        return chances_of_kind(kinds.without, requested[0], excluded[0][0], said)
    whole = regression.answer_probability(sure, requested, excluded)
    return Chances(
        whole,
        tuple(_of_part(sure, hit, reading, k, why, requested) for k in range(len(reading.parts))),
    )


def words_of_reading(reading: Reading) -> set[str]:
    """All words that a reading asks for or excludes."""
    asked = [action for part in reading.parts for action in part.actions]
    excluded = [action for exclusion in reading.exclusions for action in exclusion.actions]
    return {word for action in (*asked, *excluded) for word in action}


def counts_or_lasts(reading: Reading) -> bool:
    """Return whether a reading asks for repeats or durations."""
    return any(part.seconds > 0.0 or part.repeat_of != k for k, part in enumerate(reading.parts))


def _is_one_action(reading: Reading) -> bool:
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


def _of_part(
    sure: regression.Certainty | None,
    hit: QuestionHit,
    reading: Reading,
    k: int,
    why: Sequence[reasons.WordReason],
    requested: Sequence[tuple[float, float]],
) -> PartChance | None:
    """The certainty that a capture shows part k, unchecked without ``sure``.

    None if the part asks for nothing.
    """
    asked = [n for n, statement in enumerate(hit.statements) if statement.exclusion < 0]
    of_part = {n for n in asked if hit.statements[n].part == k}
    odds_of_part = [odds for n, odds in zip(asked, requested) if n in of_part]
    if not reading.parts[k].actions or not odds_of_part:
        return None
    by_caption = all(reason.written > 0.0 for reason in why if reason.action in of_part)
    if sure is None:
        seen = prod(_probability(odds - said) for odds, said in odds_of_part)
        return PartChance(None, seen, by_caption)
    by_motion = [float(sure.log_odds(np.array([odds - said]))) for odds, said in odds_of_part]
    return PartChance(
        prod(_probability(h + said) for h, (_, said) in zip(by_motion, odds_of_part)),
        prod(map(_probability, by_motion)),
        by_caption,
    )


def _probability(log_odds: float) -> float:
    return float(regression.probability(log_odds))


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
