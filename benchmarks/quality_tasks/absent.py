"""Absent actions: are questions whose action is not in the database distinguished from the others?

Every question is asked twice: with all captures, and without those that show its action. A method
gives the value of its best answer; the area under the ROC curve measures how well these values
distinguish the two. By words five folds by performer; by example every performer (or style) is left
out once, and where the action is taken out, its captures and their words are gone from everything
that learns by words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.meaning import asked_certainty as simulation
from motiondb.meaning import regression as certainty
from motiondb.meaning import word_map
from motiondb.meaning.resemblance import resemblance
from motiondb.meaning.score_vectors import N_POSTURE, N_TRAVEL, unit
from motiondb.meaning.word_map import clearest, usual
from motiondb.records import FloatArray
from quality_protocol import baselines as base
from quality_protocol.captures import (
    Capture,
    load_bandai,
    load_cmu,
    performer_folds,
    without_copies,
)
from quality_protocol.confidence import statistic_of
from quality_protocol.recognition import Recognised, recognise
from quality_protocol.report import Measure, Picture, TaskReport, draw
from quality_protocol.word_methods import Fold, logistic_answers
from quality_tasks.example import main_verb
from quality_tasks.words import calibration_error

OURS = "motiondb"
BEARING = N_POSTURE + N_TRAVEL
LEAST_TRAINED = 3
"""Captures that must hold a word for it to be asked, as in ``words``."""
SHOWN = 5
"""Answers of a question whose probabilities are judged: the first ones."""


@dataclass(frozen=True, eq=False)
class Material:
    """Captures as learned symbols see them, words said of each, labels ("": none), and groups."""

    seen: Recognised
    words: NDArray[np.bool_]
    names: tuple[str, ...]
    labels: NDArray[np.str_]
    groups: NDArray[np.str_]
    pooled: FloatArray
    warped: FloatArray


@dataclass(frozen=True, eq=False)
class Asked:
    """What came of all questions.

    present, absent : method -> value of the best answer, one a question, in the same order.
    probabilities, right : of the first answers where the action is there. told : per question,
    whether motiondb's threshold was right with the action present, and with it absent.
    """

    present: dict[str, list[float]]
    absent: dict[str, list[float]]
    probabilities: list[float]
    right: list[bool]
    told: list[tuple[bool, bool]]


def run(data: Path, seed: int) -> TaskReport:
    """Words, then examples of CMU and of Bandai-Namco."""
    cmu = without_copies(load_cmu(data))
    verbs = np.array([main_verb(c.captions) for c in cmu])
    spoken = _material(cmu, verbs, np.array([c.performer for c in cmu]), seed)
    bandai = without_copies(load_bandai(data))
    actions = np.array([c.captions[0] for c in bandai])
    styles = _material(bandai, actions, np.array([c.style for c in bandai]), seed)
    asked = {
        "by words, CMU": by_words(spoken),
        "by example, CMU main verbs": by_example(spoken),
        "by example, Bandai-Namco actions": by_example(styles),
    }
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, answers in asked.items():
        n = len(answers.told)
        for method in answers.present:
            rows.append((name, method, *_areas(answers, method, seed), n))
    return TaskReport(
        "Absent actions: questions whose action is not in the database",
        "Every question is asked twice: with a database that shows its action, and with the "
        "same database without the captures that show it. The measure is the area under the "
        "ROC curve of the value of the best answer (0.5 by chance). *By words*: five folds by "
        f"performer, words of at least {LEAST_TRAINED} captures of the others, the captures of "
        "the fold are the database; motiondb's value is the log-odds that the motion adds to "
        "the usual log-odds. *By example*: the query's performer (CMU) or style (Bandai-Namco) "
        "is left out; motiondb's value is the similarity of the most similar window of each "
        "capture, as in `like`. Without the action, its captures and words are also left out "
        "of learning. motiondb's value was chosen on these results, so the rows by example are "
        "slightly optimistic. Pooled and DTW: nearest capture (by words: nearest to a training "
        "capture of the word). Logistic regression: largest probability (by example: of any "
        "class). Symbols are learned from the motion of all captures.",
        ("question", "method", "area under the curve", "motiondb better by", "questions"),
        tuple(rows),
        tuple(_note(name, answers) for name, answers in asked.items()),
        (_reliability(asked),),
    )


def by_words(material: Material) -> Asked:
    """Every known word, of the fold's captures with and without those that show it."""
    answers = _nothing_yet()
    groups, words = material.groups, material.words
    folds, has = performer_folds(list(groups)), words.any(axis=1)
    cosine = material.pooled @ material.pooled.T
    for k in range(5):
        train, gallery = np.flatnonzero((folds != k) & has), np.flatnonzero((folds == k) & has)
        fold = Fold(train, gallery, words, tuple(groups), material.names)
        written = _written(material, train)
        fit = written.without(np.zeros(len(train), dtype=bool))
        sure = simulation.words_certainty(written)
        assert sure is not None
        captions = material.seen.captions(train, words[train], material.names)
        takes = material.seen.hear(fit, captions, gallery)
        heard = np.stack([0.5 * t.windows.max(axis=0) + 0.5 * t.whole for t in takes])
        added = heard - usual(fit)
        odds = logistic_answers(material.pooled, fold).word_scores
        for word in np.flatnonzero(words[train].sum(axis=0) >= LEAST_TRAINED):
            shown = words[gallery, word]
            if not shown.any() or shown.all():
                continue
            told = train[words[train, word]]
            values = {
                OURS: added[:, word],
                "pooled, cosine": cosine[np.ix_(gallery, told)].max(axis=1),
                "DTW": -material.warped[np.ix_(gallery, told)].min(axis=1),
                "logistic regression, pooled": odds[:, word],
            }
            for name, value in values.items():
                _note_value(answers, name, float(value.max()), float(value[~shown].max()))
            best = np.argsort(-heard[:, word], kind="stable")[:SHOWN]
            chances = certainty.probability(sure.log_odds(heard[best, word][:, None]))
            answers.probabilities.extend(chances.tolist())
            answers.right.extend(shown[best].tolist())
            there, gone = added[:, word].max(), added[~shown, word].max()
            answers.told.append((bool(there >= sure.threshold), bool(gone < sure.threshold)))
    return answers


def by_example(material: Material) -> Asked:
    """Every labelled capture, of the other groups' captures with and without its label."""
    answers = _nothing_yet()
    labels, groups = material.labels, material.groups
    has = material.words.any(axis=1)
    for group in np.unique(groups):
        others = np.flatnonzero((groups != group) & has)
        written = _written(material, others)
        sure = simulation.example_certainty(written)
        assert sure is not None
        queries = np.flatnonzero((groups == group) & (labels != "") & has)
        queries = queries[np.isin(labels[queries], labels[others])]
        there, clear = _values(material, queries, others)
        for label in np.unique(labels[queries]):
            same_label = labels[queries] == label
            gone = others[labels[others] != label]
            without, _ = _values(material, queries[same_label], gone)
            for name, value in there.items():
                for a, b in zip(value[same_label], without[name]):
                    _note_value(answers, name, float(a.max()), float(b.max()))
            for q, a, b in zip(queries[same_label], there[OURS][same_label], without[OURS]):
                best = np.argsort(-a, kind="stable")[:SHOWN]
                cues = np.column_stack([a[best], np.full(len(best), clear[q])])
                answers.probabilities.extend(certainty.probability(sure.log_odds(cues)).tolist())
                answers.right.extend(_same_action(material, int(q), others[best]).tolist())
                answers.told.append(
                    (bool(a.max() >= sure.threshold), bool(b.max() < sure.threshold))
                )
    return answers


def _values(
    material: Material,
    queries: NDArray[np.int64],
    gallery: NDArray[np.int64],
) -> tuple[dict[str, FloatArray], dict[int, float]]:
    """method -> array (queries, gallery): how well every capture answers every query; and how clear
    the action of every query is."""
    written = _written(material, gallery)
    fit = written.without(np.zeros(len(gallery), dtype=bool))
    actions = written.is_action & (material.words[gallery].any(axis=0))
    vectors = material.seen.vectors
    alike = np.zeros((len(queries), len(gallery)))
    for row, q in enumerate(queries):
        windows = _windows(material, int(q), gallery)
        alike[row] = resemblance(vectors[q], windows, fit, n_posture_and_travel=BEARING)
    clear = {int(q): clearest(fit, vectors[q], actions) for q in queries}
    pooled = material.pooled
    return {
        OURS: alike,
        "pooled, cosine": pooled[queries] @ pooled[gallery].T,
        "DTW": -material.warped[np.ix_(queries, gallery)],
        "logistic regression, pooled": _class_chances(material, queries, gallery),
    }, clear


def _windows(material: Material, query: int, gallery: NDArray[np.int64]) -> FloatArray:
    """Of every capture the vector of the window most like the query: array (gallery, columns)."""
    seen = material.seen
    table, length = seen.table, int(seen.table.ends[seen.part(query)][-1])
    return np.stack(
        [
            simulation.best_window(
                seen.vectors[query], seen.rows[part], table.starts[part], table.ends[part], length
            )[0]
            for part in (seen.part(int(g)) for g in gallery)
        ]
    )


def _class_chances(
    material: Material, queries: NDArray[np.int64], gallery: NDArray[np.int64]
) -> FloatArray:
    """Largest probability of a class that the gallery has, the same for all captures."""
    from sklearn.linear_model import LogisticRegression

    known = gallery[material.labels[gallery] != ""]
    model = LogisticRegression(C=10.0, max_iter=500)
    model.fit(material.pooled[known], material.labels[known])
    largest = model.predict_proba(material.pooled[queries]).max(axis=1)
    return np.repeat(largest[:, None], len(gallery), axis=1)


def _same_action(material: Material, query: int, captures: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether the captions of captures share an action with those of the query."""
    actions = np.array([name not in vocabulary.MODIFIERS for name in material.names])
    shared: NDArray[np.bool_] = (material.words[captures] & material.words[query] & actions).any(1)
    return shared


def _material(
    captures: Sequence[Capture], labels: NDArray[np.str_], groups: NDArray[np.str_], seed: int
) -> Material:
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    said = [{w for t in c.captions for w in vocabulary.words_of(t)} for c in captures]
    names = tuple(sorted(set().union(*said)))
    words = np.array([[name in s for name in names] for s in said])
    whitened = list(seen.whitened)
    pooled = unit(base.pooled(whitened))
    return Material(seen, words, names, labels, groups, pooled, base.warping_distances(whitened))


def _written(material: Material, captures: NDArray[np.int64]) -> simulation.Written:
    """Captures with their words, as the product knows them when it has learned."""
    seen, words = material.seen, material.words[captures]
    groups = np.unique(material.groups[captures], return_inverse=True)[1]
    fit = word_map.fit_word_map(seen.vectors[captures], words, groups)
    ends = np.array([seen.table.ends[seen.part(int(c))][-1] for c in captures], dtype=float)
    return simulation.Written(
        seen.vectors[captures], words, material.names, captures, np.zeros(len(captures)), ends,
        groups, seen.table, seen.rows, fit.ridge, fit.calibration, n_posture_and_travel=BEARING,
    )  # fmt: skip


def _nothing_yet() -> Asked:
    return Asked({}, {}, [], [], [])


def _note_value(answers: Asked, method: str, present: float, absent: float) -> None:
    answers.present.setdefault(method, []).append(present)
    answers.absent.setdefault(method, []).append(absent)


def area(present: FloatArray, absent: FloatArray) -> float:
    """Area under the ROC curve: how often a present value is the larger one (ties half).

    >>> area(np.array([3.0, 1.0]), np.array([2.0, 1.0]))
    0.625
    """
    above = present[:, None] > absent
    return float(np.mean(above + 0.5 * (present[:, None] == absent)))


def _areas(answers: Asked, method: str, seed: int) -> tuple[Measure, Measure | str]:
    """Area of a method and what motiondb's is larger by, with intervals over questions."""
    there, gone = np.array(answers.present[method]), np.array(answers.absent[method])
    first, last = np.array(answers.present[OURS]), np.array(answers.absent[OURS])
    measure = statistic_of(lambda units: area(there[units], gone[units]), len(there), seed)
    if method == OURS:
        return measure, ""
    return measure, statistic_of(
        lambda units: area(first[units], last[units]) - area(there[units], gone[units]),
        len(there), seed,
    )  # fmt: skip


def _note(name: str, answers: Asked) -> str:
    told = np.array(answers.told)
    error = calibration_error(np.array(answers.probabilities), np.array(answers.right, dtype=float))
    return (
        f"{name}: with the threshold learned within the training part, motiondb reports a match "
        f"for {told[:, 0].mean():.2f} of the questions whose action is present, and no match for "
        f"{told[:, 1].mean():.2f} of those whose action is absent (balanced accuracy "
        f"{told.mean():.2f}). Of the first {SHOWN} answers {np.mean(answers.right):.2f} are right, "
        f"their mean probability is {np.mean(answers.probabilities):.2f}, the calibration error "
        f"{error:.3f}. "
        + ("Right: a caption has the word." if "words" in name else "Right: the captions of both "
                                                                    "captures have a common word "
                                                                    "for an action.")
    )  # fmt: skip


def _reliability(asked: dict[str, Asked]) -> Picture:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", lw=1)
    for name, answers in asked.items():
        given, right = np.array(answers.probabilities), np.array(answers.right, dtype=float)
        bins = np.minimum((given * 10).astype(int), 9)
        there = [b for b in range(10) if (bins == b).sum() >= 10]
        axes.plot(
            [given[bins == b].mean() for b in there], [right[bins == b].mean() for b in there],
            "o-", label=name,
        )  # fmt: skip
    axes.set_xlabel("probability given to an answer")
    axes.set_ylabel("share that is right")
    axes.legend(frameon=False, fontsize=8)
    return draw(
        figure, "quality-answers-reliability.png",
        "Probabilities of the first answers to words and examples, unseen performers and styles.",
    )  # fmt: skip
