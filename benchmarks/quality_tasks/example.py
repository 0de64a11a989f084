"""Query by example: which captures show the same action as one capture, for performers or styles
never seen. Captures are ranked whole; the label is only used to judge."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.meaning import word_map
from motiondb.meaning.resemblance import (
    emphasis_of,
    fit_pooled_map,
    meaning_space,
    pooled_statistics,
    resemblance,
    with_feedback,
)
from motiondb.meaning.score_vectors import N_POSTURE, N_TRAVEL, unit
from motiondb.records import Float32Array, FloatArray
from quality_protocol import baselines as base
from quality_protocol.captures import Capture, load_bandai, load_cmu, without_copies
from quality_protocol.confidence import weighted_draws, weighted_measure
from quality_protocol.recognition import Recognised, recognise
from quality_protocol.report import Measure, TaskReport

OURS = "motiondb"
BEARING = N_POSTURE + N_TRAVEL
METHODS = (
    "motiondb compares by its vectors and by the words learned from the captions of the others "
    "(never of the query's group), as `like` does; the third row uses motion alone, as `like "
    "--by-motion-alone`. CCA (16 axes) learns from the same captions, the HMM and the logistic "
    "regression from the labels of the others. Times are the median processor time of comparing "
    "one query with all captures."
)
CHOSEN = (
    "Settings of these tables were chosen within five training parts of CMU, by leaving "
    "performers out: the weight of the words (four fifths) and the cosine without posture and "
    "travel (from 12 settings), feedback of 10 captures and half the weight for words of "
    "direction, manner and body parts (from 42), and the second word map "
    "(`motiondb/meaning/resemblance.py`, from 12). The tables were known at that time, so they "
    "are slightly optimistic."
)
VERBS = {
    "walk": "walk", "run": "run", "jog": "run", "jump": "jump", "hop": "jump", "climb": "climb",
    "sit": "sit", "dance": "dance", "dancer": "dance", "dribble": "dribble", "kick": "kick",
    "box": "box", "boxing": "box", "punch": "box", "drink": "drink", "unscrew": "drink",
    "wash": "wash", "mop": "mop", "laugh": "laugh", "direct": "direct", "stand": "stand",
    "signal": "signal", "crouch": "crouch",
}  # fmt: skip
"""Main verb of a capture: the first of these words in its captions."""
N_WORDS = 150
"""Words when times are measured, about as many as the captions of CMU hold."""
CCA_AXES = 16
"""Axes of the canonical correlation. Chosen by hand; not tuned."""


@dataclass(frozen=True, eq=False)
class Question:
    """labels: array (captures,), "" if there is none; allowed: array (captures, captures), which
    captures may be searched for which query; groups: what is left out for what learns by labels."""

    labels: NDArray[np.str_]
    allowed: NDArray[np.bool_]
    groups: NDArray[np.str_]


def run(data: Path, seed: int) -> TaskReport:
    """CMU main verbs, then Bandai-Namco by style and one by one."""
    cmu = without_copies(load_cmu(data))
    verbs = np.array([main_verb(c.captions) for c in cmu])
    who = np.array([c.performer for c in cmu])
    bandai = without_copies(load_bandai(data))
    actions = np.array([c.captions[0] for c in bandai])
    style = np.array([c.style for c in bandai])
    one = np.array([str(n) for n in range(len(bandai))])
    across = Question(verbs, (who[:, None] != who) & (verbs != ""), who)
    styles = Question(actions, style[:, None] != style, style)
    single = Question(actions, one[:, None] != one, one)
    first = _task(cmu, (across,), ("Query by example: CMU main verb, unseen performer",), seed)
    rest = _task(
        bandai,
        (styles, single),
        (
            "Query by example: Bandai-Namco, unseen style",
            "Query by example: Bandai-Namco, leave one out",
        ),
        seed,
    )
    top = first[0]
    notes = (*top.notes, CHOSEN)
    protocol = f"{top.protocol} {METHODS}"
    return TaskReport(top.title, protocol, top.columns, top.rows, notes, top.pictures, (*rest,))


def main_verb(captions: Sequence[str]) -> str:
    """The first main verb in the captions, "" if there is none.

    >>> main_verb(["basketball - forward dribble"]), main_verb(["Alaskan vacation"])
    ('dribble', '')
    """
    words = [word for text in captions for word in vocabulary.words_of(text)]
    return next((VERBS[word] for word in words if word in VERBS), "")


def _task(
    captures: Sequence[Capture], questions: Sequence[Question], titles: Sequence[str], seed: int
) -> list[TaskReport]:
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    whitened = list(seen.whitened)
    pooled = base.pooled(whitened)
    warped = -base.warping_distances(whitened)
    raw = np.concatenate([c.features for c in captures]).mean(axis=0)
    warped_raw = -base.warping_distances([c.features - raw for c in captures])
    times = _times(seen, pooled, whitened)
    reports = []
    for question, title in zip(questions, titles):
        by_groups = len(np.unique(question.groups)) < len(captures)
        methods: dict[str, FloatArray] = {OURS: _with_words(seen, captures, question)}
        methods["motiondb, without pooled statistics"] = _with_words(
            seen, captures, question, False
        )
        methods["motiondb, motion alone"] = np.stack(
            [resemblance(v, seen.vectors) for v in seen.vectors]
        )
        methods["pooled, Euclidean"] = -np.linalg.norm(pooled[:, None] - pooled, axis=2)
        methods["pooled, cosine"] = unit(pooled) @ unit(pooled).T
        methods["CCA to TF-IDF, pooled"] = _canonical_scores(unit(pooled), captures, question)
        methods["DTW, whitened features"] = warped
        methods["DTW, weighted features"] = warped_raw
        if by_groups:
            methods["HMM per class (hmmlearn)"] = _hmm_scores(whitened, question, seed)
            methods["logistic regression on classes, pooled"] = _class_scores(
                unit(pooled), question
            )
        methods["random"] = np.random.default_rng(seed).random(warped.shape)
        reports.append(_table(methods, question, title, times, seed))
    return reports


def _with_words(
    seen: Recognised, captures: Sequence[Capture], question: Question, pooled: bool = True
) -> FloatArray:
    """Likeness judged by words too; the word maps never saw a caption of the query's group."""
    statistics = np.stack([pooled_statistics(frames) for frames in seen.whitened])
    names, words = _words_said(captures)
    has = words.any(axis=1)
    scores = np.zeros((len(captures), len(captures)))
    large = _ten_parts(question.groups)
    for part in np.unique(large):
        queries = large == part
        known = ~queries & has
        groups = np.unique(question.groups[known], return_inverse=True)[1]
        if len(np.unique(groups)) > 20:
            groups = groups % 10
        fit = word_map.fit_word_map(seen.vectors[known], words[known], groups)
        second = fit_pooled_map(statistics[known], words[known]) if pooled else None
        space = meaning_space(
            fit, n_posture_and_travel=BEARING, emphasis=emphasis_of(names), pooled=second
        )
        rows = space.rows(seen.vectors, statistics)
        for query in np.flatnonzero(queries):
            there = question.allowed[query].copy()
            there[query] = False
            scores[query, there] = with_feedback(rows[there] @ rows[query], rows[there])
    return scores


def _words_said(captures: Sequence[Capture]) -> tuple[list[str], NDArray[np.bool_]]:
    """All words, and which captions hold which: array (captures, words)."""
    said = [{w for t in c.captions for w in vocabulary.words_of(t)} for c in captures]
    names = sorted(set().union(*said))
    return names, np.array([[name in s for name in names] for s in said])


def _canonical_scores(
    features: FloatArray, captures: Sequence[Capture], question: Question
) -> FloatArray:
    """Cosines where features and captions correlate most; the query's group is left out."""
    _, words = _words_said(captures)
    scores = np.zeros((len(captures), len(captures)))
    parts = _ten_parts(question.groups)
    for part in np.unique(parts):
        known = (parts != part) & words.any(axis=1)
        rows, _ = base.canonical(features[known], base.tf_idf(words[known])[0], features, CCA_AXES)
        scores[parts == part] = rows[parts == part] @ rows.T
    return scores


def _ten_parts(groups: NDArray[np.str_]) -> NDArray[np.int64]:
    """Groups as numbers; where every capture is its own, ten parts in their place."""
    number = np.unique(groups, return_inverse=True)[1]
    return number % 10 if number.max() > 20 else number


def _hmm_scores(whitened: Sequence[Float32Array], question: Question, seed: int) -> FloatArray:
    """One left-to-right-free Gaussian HMM of five states a class; a capture scores as its class."""
    import logging

    from hmmlearn.hmm import GaussianHMM

    logging.getLogger("hmmlearn").setLevel(logging.ERROR)  # "not converging", after ten rounds
    scores = np.full((len(whitened), len(whitened)), -np.inf)
    labels = question.labels
    for group in np.unique(question.groups):
        queries = np.flatnonzero((question.groups == group) & (labels != ""))
        for label in np.unique(labels[(question.groups != group) & (labels != "")]):
            examples = [whitened[int(n)].astype(float) for n in np.flatnonzero(
                (labels == label) & (question.groups != group))]  # fmt: skip
            model = GaussianHMM(5, n_iter=10, covars_prior=1.0, random_state=seed)
            model.fit(np.concatenate(examples), [len(x) for x in examples])
            for q in queries:
                x = whitened[int(q)].astype(float)
                scores[q, labels == label] = model.score(x) / len(x)
    return scores


def _class_scores(features: FloatArray, question: Question) -> FloatArray:
    """Multinomial logistic regression; a capture scores as its class does."""
    from sklearn.linear_model import LogisticRegression

    labels = question.labels
    scores = np.full((len(features), len(features)), -np.inf)
    for group in np.unique(question.groups):
        queries = question.groups == group
        known = ~queries & (labels != "")
        model = LogisticRegression(C=10.0, max_iter=500).fit(features[known], labels[known])
        odds = model.predict_log_proba(features[queries])
        for column, label in enumerate(model.classes_):
            scores[np.ix_(queries, labels == label)] = odds[:, [column]]
    return scores


def _table(
    methods: dict[str, FloatArray], question: Question, title: str, times: dict[str, float],
    seed: int,
) -> TaskReport:  # fmt: skip
    judged = {name: _judge(scores, question) for name, scores in methods.items()}
    asked = ~np.isnan(judged[OURS][0])
    weights = weighted_draws(len(asked), seed)[:, asked]
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, results in judged.items():
        row: list[str | float | Measure] = [name]
        for values, ours in zip(results, judged[OURS]):
            row.append(_measure(values[asked], weights))
            row.append("" if name == OURS else _measure((ours - values)[asked], weights))
        rows.append((*row, f"{times[name]:.3f}" if name in times else "-"))
    classes = len(set(question.labels[asked].tolist()))
    group_name = "performer or style" if len(set(question.groups)) < len(asked) else "capture"
    protocol = (
        f"{int(asked.sum())} queries of {classes} classes; the query's {group_name} is never "
        "searched."
    )
    columns = (
        "method", "1-NN accuracy", "motiondb better by", "mAP", "motiondb better by",
        "ms a query, searching",
    )  # fmt: skip
    notes = _confusions(methods[OURS], question)
    return TaskReport(title, protocol, columns, tuple(rows), notes)


def _judge(scores: FloatArray, question: Question) -> tuple[FloatArray, FloatArray]:
    """Nearest right? and average precision of every query; NaN if nothing can be found.

    Among equal scores (classes) the average precision is that of a random order.
    """
    n = len(scores)
    nearest, precision = np.full(n, np.nan), np.full(n, np.nan)
    jitter = np.random.default_rng(0).random(n) * 1e-9
    for q in range(n):
        there = question.allowed[q].copy()
        there[q] = False
        right = question.labels[there] == question.labels[q]
        if not question.labels[q] or not right.any():
            continue
        hits = right[np.argsort(-(scores[q, there] + jitter[there]), kind="stable")]
        nearest[q] = hits[0]
        precision[q] = (np.cumsum(hits) / np.arange(1, len(hits) + 1))[hits].mean()
    return nearest, precision


def _measure(values: FloatArray, weights: FloatArray) -> Measure:
    return weighted_measure(weights @ values / np.maximum(weights.sum(axis=1), 1e-12))


def _confusions(scores: FloatArray, question: Question) -> tuple[str, ...]:
    wrong: dict[tuple[str, str], int] = {}
    for q, label in enumerate(question.labels):
        there = np.flatnonzero(question.allowed[q] & (np.arange(len(scores)) != q))
        if not label or not (question.labels[there] == label).any():
            continue
        nearest = str(question.labels[there[np.argmax(scores[q, there])]])
        if nearest != label:
            wrong[str(label), nearest] = wrong.get((str(label), nearest), 0) + 1
    worst = sorted(wrong.items(), key=lambda item: -item[1])[:6]
    listed = "; ".join(f"{a} taken for {b} ({n})" for (a, b), n in worst)
    return (f"Most frequent mistakes of motiondb: {listed}.",) if worst else ()


def _times(
    seen: Recognised, pooled: FloatArray, whitened: Sequence[Float32Array]
) -> dict[str, float]:
    """Median milliseconds of processor time to compare one query with all captures; their vectors,
    meanings and features are there."""
    some = range(0, len(whitened), max(len(whitened) // 40, 1))
    rng = np.random.default_rng(0)  # times do not depend on the values
    weights, any_word = rng.normal(size=(seen.vectors.shape[1], N_WORDS)), rng.normal(size=N_WORDS)
    fit = word_map.WordMap(weights, any_word, any_word, any_word, np.ones(3))
    rows = unit(pooled)
    space = meaning_space(
        fit,
        n_posture_and_travel=BEARING,
        emphasis=np.ones(N_WORDS),
        pooled=fit_pooled_map(pooled, rng.random((len(pooled), N_WORDS)) < 0.1),
    )
    meanings = space.rows(seen.vectors, pooled)
    base.warping_row(whitened[0], whitened[:1])
    actions: dict[str, Callable[[int], object]] = {
        OURS: lambda q: with_feedback(meanings @ space.rows(seen.vectors[q], pooled[q]), meanings),
        "motiondb, motion alone": lambda q: resemblance(seen.vectors[q], seen.vectors),
        "pooled, cosine": lambda q: rows @ rows[q],
        "DTW, whitened features": lambda q: base.warping_row(whitened[q], whitened),
    }
    times_of = {}
    for name, action in actions.items():
        times = []
        for q in some:
            started = time.process_time()
            action(q)
            times.append(time.process_time() - started)
        times_of[name] = float(np.median(times[1:])) * 1e3
    return times_of
