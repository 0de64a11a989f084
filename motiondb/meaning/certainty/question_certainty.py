"""Certainty of answers to "a but not b" and to "a or b", learned from questions of captions.

The log-odds of an action and of an excluded one are not independent, and the questions that people
ask with "not" and "or" are about actions that occur together or in place of one another. So the
probability of single words, multiplied, is wrong for them: for "a but not b" it was .41 in the mean
where .67 of the answers were right. Instead, such questions are made from the captions, if the
captures of a fold of performers distinguish them:

    a but not b    some captures show a with b, and some a without b,
    a or b         some captures show a without b, and some b without a,

and searched in these captures with the word map without these performers. The first answers show
how often they are right. For each kind two probabilities are learned from the same cues: that all
of the question holds, and that the action that the answer shows does (a; for "or" the alternative
that the capture shows best).

Cues: for "a but not b" the log-odds of a and those of b with reversed sign; for "a or b" the
log-odds of the alternative that is shown best. The usual log-odds of the words as further cues made
answers about unseen performers less certain.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motiondb.language.question.readings import Exclusion, Part, Reading
from motiondb.meaning.calibration import Certainty, fit_probability
from motiondb.meaning.certainty.asked_certainty import (
    LEAST_ANSWERS,
    LEAST_SAID,
    MOST_CAPTURES,
    N_FOLDS,
    Written,
    performer_folds,
)
from motiondb.meaning.evidence import by_question, by_words
from motiondb.meaning.evidence.by_words import TakeScores
from motiondb.meaning.maps.word_map import WordMap
from motiondb.records import FloatArray, IntArray

LEAST_EACH = 2  # Smallest number of captures on each side of the distinction of a question
FIRST = 5  # Answers of a question that are used: those that a user reads first
MOST_QUESTIONS = 100
"""Largest number of questions of a kind and a fold, a bound on the duration of learning."""


@dataclass(frozen=True)
class KindCertainty:
    """Certainty of answers to one kind of question."""

    whole: Certainty | None = None  # Certainty that all of the question holds
    # Certainty that the capture shows the action that the answer shows
    part: Certainty | None = None


@dataclass(frozen=True, eq=False)
class MadeQuestion:
    """A question made from captions."""

    readings: tuple[Reading, ...]
    right: NDArray[np.bool_]  # (captures,): which captures show all of it
    # (readings, captures): which captures show the action that each reading asks for
    shown: NDArray[np.bool_]


@dataclass(frozen=True)
class _Answers:
    """Cues of answers, and whether all of the question and the part are right."""

    cues: list[FloatArray] = field(default_factory=list)
    whole: list[bool] = field(default_factory=list)
    part: list[bool] = field(default_factory=list)

    def fit(self) -> KindCertainty:
        cues = np.array(self.cues)
        return KindCertainty(_fit(cues, self.whole), _fit(cues, self.part))


def without_and_either(written: Written) -> tuple[KindCertainty, KindCertainty]:
    """Certainties of answers to "a but not b" and to "a or b"."""
    without, either = _Answers(), _Answers()
    folds = performer_folds(written.groups)
    for fold in range(N_FOLDS):
        inside = folds == fold
        known = (written.presence[~inside].sum(axis=0) >= LEAST_SAID) & written.is_action
        if not known.any() or not inside.any():
            continue
        words = written.without(inside)
        captures = np.unique(written.captures[inside])
        captures = captures[_evenly(len(captures), MOST_CAPTURES)]
        takes = [_log_odds_in(written, words, int(c)) for c in captures]
        shown = np.stack([written.presence[written.captures == c].any(axis=0) for c in captures])
        verbs = np.flatnonzero(known)
        for answers, questions in (
            (without, list(without_questions(shown, verbs, written.names))),
            (either, list(either_questions(shown, verbs, written.names))),
        ):
            for n in _evenly(len(questions), MOST_QUESTIONS):
                _ask(answers, takes, questions[n], written.names)
    return without.fit(), either.fit()


def cues_of(asked: float, excluded: float | None) -> FloatArray:
    """Cues of an answer: array (1,) or, where something is excluded, array (2,)."""
    return np.array([asked] if excluded is None else [asked, -excluded])


def without_questions(
    shown: NDArray[np.bool_], verbs: IntArray, names: Sequence[str]
) -> Iterator[MadeQuestion]:
    """Questions "a but not b" that some captures distinguish.

    Shapes: `shown` (captures, words); `verbs` (verbs,).
    """
    for a in verbs:
        for b in verbs:
            both, alone = shown[:, a] & shown[:, b], shown[:, a] & ~shown[:, b]
            if a != b and min(both.sum(), alone.sum()) >= LEAST_EACH:
                excluded = Exclusion(((names[b],),), 0, 1)
                reading = Reading((Part(((names[a],),)),), (excluded,))
                yield MadeQuestion((reading,), alone, shown[:, [a]].T)


def either_questions(
    shown: NDArray[np.bool_], verbs: IntArray, names: Sequence[str]
) -> Iterator[MadeQuestion]:
    """Questions "a or b" that some captures distinguish; parameters as `without_questions`."""
    for n, a in enumerate(verbs):
        for b in verbs[n + 1 :]:
            only_a, only_b = shown[:, a] & ~shown[:, b], shown[:, b] & ~shown[:, a]
            either = shown[:, a] | shown[:, b]
            if min(only_a.sum(), only_b.sum()) >= LEAST_EACH and not either.all():
                read = tuple(Reading((Part(((names[w],),)),)) for w in (a, b))
                yield MadeQuestion(read, either, shown[:, [a, b]].T)


def _ask(
    answers: _Answers, takes: Sequence[TakeScores], question: MadeQuestion, names: Sequence[str]
) -> None:
    """Search the captures for one question, and record its first answers."""
    number = {name: n for n, name in enumerate(names)}
    hits = [by_question.search_take(take, question.readings, number) for take in takes]
    ranked = [(n, hit) for n, hit in enumerate(hits) if hit is not None]
    ranked.sort(key=lambda pair: -pair[1].log_odds)
    for n, hit in ranked[:FIRST]:
        asked, excluded = by_question.split_statements(hit.statements)
        answers.cues.append(cues_of(asked[0], excluded[0] if excluded else None))
        answers.whole.append(bool(question.right[n]))
        answers.part.append(bool(question.shown[hit.reading, n]))


def _log_odds_in(written: Written, words: WordMap, capture: int) -> TakeScores:
    """Log-odds of all words in a capture, from its motion."""
    rows = written.segments[capture]
    starts, ends = written.table.starts[rows], written.table.ends[rows]
    odds = by_words.motion_log_odds(words, written.standardised[rows], starts, ends, written.margin)
    return TakeScores(starts, ends, odds[:-1], odds[-1])


def _evenly(n: int, most: int) -> IntArray:
    """At most ``most`` of the numbers 0 to n - 1, at even distances."""
    return np.unique(np.linspace(0, max(n - 1, 0), min(n, most)).astype(np.int64))


def _fit(cues: FloatArray, right: Sequence[bool]) -> Certainty | None:
    """Fit a probability; None if too few answers are known, or all are right or all wrong."""
    truth = np.array(right, dtype=bool)
    if len(truth) < LEAST_ANSWERS or truth.all() or not truth.any():
        return None
    weights, constant = fit_probability(cues, truth)
    return Certainty(weights, constant, float("nan"))
