"""Places of words learned from captions of whole takes: variants, and how sure they are told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb.errors import MotionDBError
from motiondb.learning import place_fitting
from motiondb.learning.answers.word_answers import search_words
from motiondb.learning.certainty import place_certainty
from motiondb.learning.certainty.place_certainty import Judged
from motiondb.learning.learned import Learned
from motiondb.records import FloatArray
from motiondb.search.certainty import probability
from motiondb.words.lexicon import vocabulary
from motiondb.words.maps.place_map import fit_places
from quality_protocol.report import TaskReport
from quality_protocol.takes import LongTake

N_FOLDS, N_BINS, N_DRAWS = 5, 10, 10
"""Folds of performers, bins of the calibration error, and draws of joined takes."""

Asked = Sequence[tuple[str, str, float]]
"""Capture, label, intersection over union of the first answer."""
Share = Callable[[LongTake, str, tuple[float, float]], float]


def place_answers(
    database: Path,
    takes: Sequence[LongTake],
    labels: Mapping[str, Sequence[str]],
    words: Mapping[str, str],
    share: Share,
) -> tuple[dict[str, Asked], list[tuple[str, str]]]:
    """Answers of the variants by name; the questions whose words the take's own caption says.

    Parameters
    ----------
    database : Path
        A database that has learned.
    takes : sequence of LongTake
    labels : mapping of str to sequence of str
        Capture -> the labels asked of it.
    words : mapping of str to str
        Label -> the words that are asked.
    share : callable
        Take, label and interval (seconds) -> intersection over union.
    """
    variants: dict[str, list[tuple[str, str, float]]] = {"map": [], "left": []}
    said: list[tuple[str, str]] = []
    with motiondb.open(database, read_only=True) as db:
        learned = db.learned
        numbers = {info.name: capture for capture, info in learned.captures.items()}
        for take in takes:
            name, capture = take.capture.name, numbers[take.capture.name]
            without = replace(learned, places=_places_without(learned, capture))
            for label in labels[name]:
                for variant, of in (("map", replace(learned, places=None)), ("left", without)):
                    interval = _first(of, words[label], capture)
                    value = 0.0 if interval is None else share(take, label, interval)
                    variants[variant].append((name, label, value))
                if _says(learned, capture, words[label]):
                    said.append((name, label))
    return dict(variants), said


def calibration(database: Path, seed: int) -> TaskReport:
    """Whether the probability that a place is right is right, on joined captures."""
    with motiondb.open(database, read_only=True) as db:
        joined, whole = _judge_folds(db.learned, seed)
    rows = tuple(
        (name, len(of), _mean(r for _, r in of), _mean(p for p, _ in of), _error(of))
        for name, of in (
            ("joined captures and whole captures, as many", joined + whole),
            ("joined captures alone", joined),
            ("whole captures alone", whole),
        )
        if of
    )
    return TaskReport(
        "How sure a place is",
        "Short captures of one performer and one action each are put one after another; every "
        "action is asked of the joined take, and the interval counts as right from an "
        "intersection over union of 0.5. The same is asked of the captures as they are, where the "
        "whole is the truth. Performers are divided into five folds: what is known of the other "
        "folds gives the probability that the interval is right, and the map is fitted without "
        "the performer. Expected calibration error: ten bins, weighted by their questions. Each "
        f"capture is joined {N_DRAWS} times, so that the questions are not independent.",
        ("asked of", "questions", "right", "mean probability", "expected calibration error"),
        rows,
    )


def _judge_folds(
    learned: Learned, seed: int
) -> tuple[list[tuple[float, bool]], list[tuple[float, bool]]]:
    """(probability, right) of questions of joined takes, and of as many whole captures."""
    places, table, standardised = learned.places, learned.segments, learned.standardised
    assert places is not None
    written = _written(learned)
    performers = {c: learned.captures[c].tags.get("performer", str(c)) for c in learned.rows}
    short = place_certainty.short_captures(table, standardised, written, performers)
    captures, takes, shown = place_fitting.placed_takes(
        places, table, standardised, len(written.numbers)
    )
    owners = np.array([performers[c] for c in captures])[takes.owners]
    fit = fit_places(takes, shown)
    groups = sorted({capture.group for capture in short})
    maps = {group: fit.without(np.flatnonzero(owners == group)) for group in groups}
    rng = np.random.default_rng(seed)
    folds = dict(zip(rng.permutation(groups).tolist(), np.arange(len(groups)) % N_FOLDS))
    joined: list[tuple[float, bool]] = []
    whole: list[tuple[float, bool]] = []
    for fold in range(N_FOLDS):
        rest = [capture for capture in short if folds[capture.group] != fold]
        own = [capture for capture in short if folds[capture.group] == fold]
        sure = place_certainty.fit_certainty(rest, maps, rng)
        if sure is None:
            continue
        for _ in range(N_DRAWS):
            many = [
                one for take in place_certainty.join_captures(own, rng)
                for one in place_certainty.judge(take, maps[take.group])
            ]  # fmt: skip
            some = [own[i] for i in rng.permutation(len(own))[: len(many)]]
            single = [
                one for each in some
                for one in place_certainty.judge(place_certainty.join([each]), maps[each.group])
            ]  # fmt: skip
            joined += [_told(sure.log_odds(one.cues), one) for one in many]
            whole += [_told(sure.log_odds(one.cues), one) for one in single]
    return joined, whole


def _told(log_odds: FloatArray, judged: Judged) -> tuple[float, bool]:
    return float(probability(log_odds)), judged.right


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _error(told: Sequence[tuple[float, bool]]) -> float:
    """Expected calibration error of (probability, right)."""
    p, right = (np.array(column, dtype=float) for column in zip(*told))
    bins = np.minimum((p * N_BINS).astype(int), N_BINS - 1)
    return float(sum(
        (bins == b).mean() * abs(p[bins == b].mean() - right[bins == b].mean())
        for b in np.unique(bins)
    ))  # fmt: skip


def _first(learned: Learned, text: str, capture: int) -> tuple[float, float] | None:
    try:
        found = search_words(learned, text, [capture], limit=1, written=False).matches
    except MotionDBError:  # none of the words is known
        return None
    return (found[0].start, found[0].end) if found else None


def _written(learned: Learned, without: int | None = None) -> place_fitting.Written:
    captions = {c: rows for c, rows in learned.captions.items() if c != without}
    return place_fitting.Written(captions, learned.synonyms, learned.lemmas, learned.word_numbers)


def _places_without(learned: Learned, capture: int) -> place_fitting.Places | None:
    """Places found as if nobody had written about a capture."""
    return place_fitting.find_places(
        learned.segments, learned.standardised, _written(learned, capture)
    )


def _says(learned: Learned, capture: int, text: str) -> bool:
    """Whether captions of a whole capture hold all words of a text that are known."""
    written = _written(learned)
    said = {w for actions in written.of_whole(capture) for action in actions for w in action}
    asked = {
        learned.word_numbers[word]
        for action in vocabulary.split_actions(text, learned.synonyms, learned.lemmas)
        for word in action
        if word in learned.word_numbers
    }
    return bool(asked) and asked <= said
