"""Questions with "not" and "or", made from real captions: the tree against the ignoring reading.

Five folds by performer. Per fold, words of the other performers' captures are known; the fold's
captures are the gallery, and their words are only used to judge. A pair of verbs a, b is used if
captures of the gallery distinguish the questions:

    a but not b   captures show a without b, and a with b
    a or b        captures show a without b, and b without a
    not a         captures show a, and captures do not

"Ignored" is how the same sentence was read before questions had a tree: "not" and "or" are left
out, and the other words are looked for together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import hold_to_known, readings
from motiondb.meaning import asked_certainty, by_question, word_evidence, word_map
from motiondb.meaning import regression as certainty
from motiondb.meaning.asked_certainty import fit_certainties
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.regression import Certainties
from motiondb.meaning.score_vectors import N_POSTURE, N_TRAVEL, unit
from motiondb.records import FloatArray
from motiondb.search.chances import chances_of_kind
from quality_protocol import baselines as base
from quality_protocol.captures import Capture, load_cmu, performer_folds, without_copies
from quality_protocol.confidence import weighted_draws, weighted_measure
from quality_protocol.recognition import Recognised, recognise
from quality_protocol.report import Measure, TaskReport
from quality_protocol.word_methods import Fold, logistic_answers
from quality_tasks.words import Judged, average_precisions, calibration_error

OURS = "motiondb, the tree"
LEAST_TRAINED, LEAST_EACH = 3, 2
"""Training captures of a verb; captures of the gallery on each side of the distinction."""
KINDS = ("a but not b", "a or b", "not a")
FIRST = 5
"""Answers of a question whose probabilities are judged."""


@dataclass(frozen=True, eq=False)
class Question:
    """kind, text; right: array (gallery,); verbs: columns of a and b, -1 if there is no b."""

    kind: str
    text: str
    right: NDArray[np.bool_]
    verbs: tuple[int, int]


@dataclass(eq=False)
class Collected:
    """method -> kind -> (fold, number) -> captures in ranked order and which are right; and the
    probabilities of the first answers, by kind."""

    ranked: dict[str, dict[str, dict[tuple[int, int], tuple[NDArray[np.int64], NDArray[np.bool_]]]]]
    given: dict[str, list[float]] = field(default_factory=dict)
    true: dict[str, list[float]] = field(default_factory=dict)


def run(data: Path, seed: int) -> TaskReport:
    """Mean average precision by kind of question and method."""
    captures = without_copies(load_cmu(data))
    said = [{w for text in c.captions for w in vocabulary.words_of(text)} for c in captures]
    names = sorted(set().union(*said))
    words = np.array([[name in each for name in names] for each in said])
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    pooled = unit(base.pooled(list(seen.whitened)))
    performers = tuple(c.performer for c in captures)
    number, has = performer_folds(performers), words.any(axis=1)
    collected = Collected({})
    for k in range(5):
        fold = Fold(np.flatnonzero((number != k) & has), np.flatnonzero((number == k) & has), words,
                    performers, tuple(names))  # fmt: skip
        _ask_fold(k, fold, names, seen, pooled, collected)
    return _report(collected, captures, seed)


def _ask_fold(
    k: int,
    fold: Fold,
    names: Sequence[str],
    seen: Recognised,
    pooled: FloatArray,
    collected: Collected,
) -> None:
    written = _written(fold, names, seen)
    fit = written.without(np.zeros(len(fold.train), dtype=bool))
    sure = fit_certainties(written)
    shown = fold.words[fold.gallery]
    captions = seen.captions(fold.train, fold.words[fold.train], names)
    takes = seen.hear(fit, captions, fold.gallery)
    odds = logistic_answers(pooled, fold).word_scores
    counts = {name: int(n) for name, n in zip(names, fold.words[fold.train].sum(axis=0)) if n}
    for n, question in enumerate(_questions(fold, names)):
        scores, chances = _by_tree(question, takes, (names, counts, shown), sure)
        answers = {
            OURS: scores,
            "motiondb, alternatives by their sum": _by_sum(question, takes, scores),
            "motiondb, ignored": _ignored(question.text, takes, names),
            "logistic regression, pooled, by the same logic": _logic(question, odds),
            "logistic regression, pooled, ignored": _asked_words(question, odds),
        }
        for method, values in answers.items():
            order = np.argsort(-values, kind="stable")
            kinds = collected.ranked.setdefault(method, {kind: {} for kind in KINDS})
            kinds[question.kind][k, n] = (fold.gallery[order], question.right[order])
        best = np.argsort(-scores, kind="stable")[:FIRST]
        for name, given, true in (
            (question.kind, chances[:, 0], question.right),
            (f"{question.kind}, part", chances[:, 1], chances[:, 2]),
        ):
            collected.given.setdefault(name, []).extend(given[best].tolist())
            collected.true.setdefault(name, []).extend(true[best].astype(float))


def _written(fold: Fold, names: Sequence[str], seen: Recognised) -> asked_certainty.Written:
    """The training captures with their words, as a database knows them when it has learned."""
    words, vectors = fold.words[fold.train], seen.vectors[fold.train]
    groups = np.unique([fold.performers[t] for t in fold.train], return_inverse=True)[1]
    fit = word_map.fit_word_map(vectors, words, groups)
    ends = np.array([seen.table.ends[seen.part(int(c))][-1] for c in fold.train], dtype=float)
    return asked_certainty.Written(
        vectors, words, names, fold.train, np.zeros(len(fold.train)), ends, groups, seen.table,
        seen.rows, fit.ridge, fit.calibration, n_posture_and_travel=N_POSTURE + N_TRAVEL,
    )  # fmt: skip


def _questions(fold: Fold, names: Sequence[str]) -> Iterator[Question]:
    """All questions that the gallery distinguishes, in the order of their words."""
    shown = fold.words[fold.gallery]
    known = fold.words[fold.train].sum(axis=0) >= LEAST_TRAINED
    verbs = [w for w, name in enumerate(names) if known[w] and name not in vocabulary.MODIFIERS]
    for a in verbs:
        if min(shown[:, a].sum(), (~shown[:, a]).sum()) >= LEAST_EACH:
            yield Question("not a", f"not {names[a]}", ~shown[:, a], (a, -1))
        for b in verbs:
            both, only_a, only_b = (
                int(side.sum()) for side in (
                    shown[:, a] & shown[:, b], shown[:, a] & ~shown[:, b],
                    shown[:, b] & ~shown[:, a],
                )
            )  # fmt: skip
            if a != b and both >= LEAST_EACH and only_a >= LEAST_EACH:
                right = shown[:, a] & ~shown[:, b]
                yield Question("a but not b", f"{names[a]} but not {names[b]}", right, (a, b))
            if a < b and only_a >= LEAST_EACH and only_b >= LEAST_EACH:
                right = shown[:, a] | shown[:, b]
                if not right.all():
                    yield Question("a or b", f"{names[a]} or {names[b]}", right, (a, b))


def _by_tree(
    question: Question,
    takes: Sequence[word_evidence.TakeScores],
    said: tuple[Sequence[str], dict[str, int], NDArray[np.bool_]],
    sure: Certainties,
) -> tuple[FloatArray, FloatArray]:
    """Log-odds of every capture as ``search`` gives them, and its chances.

    said : the words, how often each is known, and which captures show which.
    chances : array (captures, 3), of the question, of its part, and whether the part is shown.
    """
    names, counts, shown = said
    number = {name: n for n, name in enumerate(names)}
    read, _ = readings(hold_to_known(parse(question.text), counts).tree)
    hits = [by_question.search_take(take, read, number) for take in takes]
    scores = np.array([-np.inf if hit is None else hit.log_odds for hit in hits])
    told = np.zeros((len(takes), 3))
    for n, hit in enumerate(hits):
        if hit is not None:
            told[n, :2] = _chances(question.kind, hit, sure)
            parts = read[hit.reading].parts
            asked = [number[word] for part in parts for action in part.actions for word in action]
            told[n, 2] = shown[n, asked].all()
    return scores, told


def _chances(kind: str, hit: QuestionHit, sure: Certainties) -> tuple[float, float]:
    """Probability of an answer and of its part, from ``search``; 0.5 if there is none."""
    asked, excluded = by_question.split_statements(hit.statements)
    if kind == "not a":
        if sure.words is None:
            return 0.5, 0.5
        log_odds = [sure.words.log_odds(np.array([value])) for value in excluded]
        shown = [[float(certainty.probability(each))] for each in log_odds]
        one = certainty.answer_probability([], shown)
        return one, one
    of_kind = sure.either if kind == "a or b" else sure.without
    told = chances_of_kind(of_kind, (asked[0], 0.0), (excluded[0], 0.0) if excluded else None)
    part = told.parts[0]
    if told.whole is None or part is None or part.probability is None:
        return 0.5, 0.5
    return told.whole, part.probability


def _by_sum(
    question: Question, takes: Sequence[word_evidence.TakeScores], scores: FloatArray
) -> FloatArray:
    """Alternatives by the log-odds that at least one of them, independent ones, is shown."""
    if question.kind != "a or b":
        return scores
    each = np.stack([
        [hit.log_odds for take in takes if (hit := by_question.search_order(take, [[verb]]))]
        for verb in question.verbs
    ])  # fmt: skip
    log_none = -np.logaddexp(0.0, each).sum(axis=0)
    log_odds: FloatArray = np.log(-np.expm1(log_none)) - log_none
    return log_odds


def _ignored(
    text: str, takes: Sequence[word_evidence.TakeScores], names: Sequence[str]
) -> FloatArray:
    """As the sentence was read before: its known words, without "not" and "or"."""
    number = {name: n for n, name in enumerate(names)}
    actions = [[number[w] for w in action] for action in vocabulary.split_actions(text)]
    hits = [by_question.search_order(take, actions) for take in takes]
    return np.array([-np.inf if hit is None else hit.log_odds for hit in hits])


def _logic(question: Question, odds: FloatArray) -> FloatArray:
    """Log-probability of the question from the words' log-odds, taken as independent."""
    a = odds[:, question.verbs[0]]
    if question.kind == "not a":
        return -a
    b = odds[:, question.verbs[1]]
    if question.kind == "a or b":
        return np.maximum(a, b)
    return -np.logaddexp(0.0, -a) - np.logaddexp(0.0, b)


def _asked_words(question: Question, odds: FloatArray) -> FloatArray:
    """Mean log-odds of the words, without "not" and "or"."""
    scores: FloatArray = odds[:, [verb for verb in question.verbs if verb >= 0]].mean(axis=1)
    return scores


def _report(collected: Collected, captures: Sequence[Capture], seed: int) -> TaskReport:
    weights = weighted_draws(len(captures), seed)
    empty = np.zeros(0)

    def precision(method: str, kind: str) -> FloatArray:
        ranks = collected.ranked[method][kind]
        return average_precisions(Judged(ranks, empty, empty, empty, (empty, empty)), weights)

    rows: list[tuple[str | float | Measure, ...]] = []
    for kind in KINDS:
        ours = precision(OURS, kind)
        for method in collected.ranked:
            if method == "motiondb, alternatives by their sum" and kind != "a or b":
                continue
            values = precision(method, kind)
            better = "" if method == OURS else weighted_measure(ours - values)
            n = str(len(collected.ranked[method][kind]))
            rows.append((kind, method, weighted_measure(values), better, n))
    notes = (
        *(f"{kind}: {_sureness(collected, kind)}" for kind in KINDS),
        f'The part of "a but not b" (a): {_sureness(collected, "a but not b, part")} The part of '
        f'"a or b" (the alternative shown best): {_sureness(collected, "a or b, part")}',
        "The probabilities of these answers are learned from questions made in the same way "
        "from the captions of the training performers, with performers among them left out.",
    )
    return TaskReport(
        "Questions with not and or",
        f"{len(captures)} CMU captures, 15 performers, five folds by performer. Questions are made "
        f"of verbs with at least {LEAST_TRAINED} training captures, if at least {LEAST_EACH} "
        "captures of the gallery are on each side of the distinction: \"a but not b\" if some show "
        "a with b and some a without b, \"a or b\" if some show only a and some only b, \"not a\" "
        "if some show a and some do not. The captions decide what is right. Ignored: the same "
        "sentence without \"not\" and \"or\", searched as one action with all its words. Mean "
        "average precision over questions; intervals over captures.",
        ("question", "method", "mean average precision", "the tree better by", "questions"),
        tuple(rows), notes,
    )  # fmt: skip


def _sureness(collected: Collected, kind: str) -> str:
    """How often the first answers are right, and what probability they were given."""
    given, true = np.array(collected.given[kind]), np.array(collected.true[kind])
    return (
        f"of the first {FIRST} answers to every question {true.mean():.3f} are right, their mean "
        f"probability is {given.mean():.3f}, the expected calibration error "
        f"{calibration_error(given, true):.3f}."
    )
