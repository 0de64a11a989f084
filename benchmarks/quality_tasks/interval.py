"""Intervals in the long takes: by example and by word.

By example: every true part is the query once, the other long takes are searched, and the first
answer counts by its intersection over union with the parts of the same label. By word: the same
with a label's words, where the words were learned from captions only.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb import store
from motiondb.body.features import FEATURE_FPS
from motiondb.database import MotionDB
from motiondb.errors import MotionDBError
from motiondb.learn.recognition import LearnSettings
from motiondb.meaning import alignment
from motiondb.records import Float32Array, FloatArray
from motiondb.symbols import feature_space
from quality_protocol.captures import load_cmu
from quality_protocol.confidence import mean_of
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, TaskReport
from quality_protocol.takes import LongTake, load_takes, union_share
from quality_tasks import interval_places

SHARES = (0.3, 0.5, 0.7)
"""Overlaps (intersection over union) from which an interval counts as right, as in the literature
on temporal grounding."""
WORDS = {
    "JumpJack": "jumping jack", "Jog": "jog", "Squat": "squat", "KneeRaise": "raise knee",
    "SideBend": "side bend", "SideReach": "side reach", "Twist": "twist", "Box": "box",
    "ArmCircle": "arm circle", "UpDown": "up down", "ToeTouchTwoHands": "touch toe",
    "walk": "walk", "jump": "jump", "punch": "punch", "leg_kick": "kick",
}  # fmt: skip
"""What one would ask for to find a label."""

Found = tuple[float, float, float]
"""score (larger is better), start, end (seconds)."""
Finder = Callable[[LongTake, tuple[float, float], LongTake], Found]
"""take of the query, its interval, take to search -> best answer."""


@dataclass(frozen=True)
class Judged:
    """Intersection over union of first answers: over all other takes, and take by take."""

    overall: tuple[float, ...]
    per_take: tuple[float, ...]


def run(data: Path, seed: int) -> TaskReport:
    """By example and by word, with baselines."""
    return measure(learned_database(data, seed), data, seed)


def measure(database: Path, data: Path, seed: int) -> TaskReport:
    """The same on a database that has learned."""
    captures = load_cmu(data)
    takes = load_takes(data, captures)
    space = feature_space.fit_feature_space([c.features for c in captures])
    whitened = {t.capture.name: space.project(t.capture.features) for t in takes}
    with motiondb.open(database, read_only=True) as db:
        finders: dict[str, Finder] = {
            "motiondb (like)": _by_motiondb(db),
            "motiondb (like --by-motion-alone)": _by_motiondb(db, meaning=False),
            "subsequence DTW": _by_warping(whitened),
            "sliding windows, pooled features": _by_windows(whitened),
        }
        judged = {name: judge(takes, finder) for name, finder in finders.items()}
    rows: tuple[tuple[str | float | Measure, ...], ...] = tuple(
        (name, *_row(j, seed)) for name, j in judged.items()
    )
    columns = ("method", *(f"R@1, IoU {s}" for s in SHARES))
    columns += tuple(f"per query and take, IoU {s}" for s in SHARES)
    n = len(next(iter(judged.values())).overall), len(next(iter(judged.values())).per_take)
    return TaskReport(
        "Interval in a long take",
        f"Each true part of a long take whose label also occurs in other long takes ({n[0]} "
        "parts) is a query; the other long takes are searched, and the first answer over all of "
        "them counts. Per query and take: the first answer within each take that has the label "
        f"({n[1]}). No labels are used; `like` uses the words that were learned from the captions "
        "of whole captures. "
        "Intervals are over queries.",
        columns,
        rows,
        _notes(judged, takes),
        (),
        (_by_word(database, takes, seed),),
    )


def judge(takes: Sequence[LongTake], find: Finder) -> Judged:
    """Ask all parts of all takes."""
    overall, per_take = [], []
    for take, part, others in questions(takes):
        answers = [(find(take, part[:2], other), other) for other in takes if other is not take]
        (_, start, end), where = max(answers, key=lambda a: a[0][0])
        overall.append(best_share(where, part[2], (start, end)))
        for (_, low, high), other in answers:
            if other in others:
                per_take.append(best_share(other, part[2], (low, high)))
    return Judged(tuple(overall), tuple(per_take))


def questions(
    takes: Sequence[LongTake],
) -> Iterator[tuple[LongTake, tuple[float, float, str], list[LongTake]]]:
    """Parts that have a like in other takes, and these takes."""
    for take in takes:
        for part in take.parts:
            others = [
                t for t in takes if t is not take and part[2] in [label for _, _, label in t.parts]
            ]
            if others:
                yield take, part, others


def best_share(take: LongTake, label: str, interval: tuple[float, float]) -> float:
    """Largest intersection over union with a part of the label; 0 if the take has none."""
    return max((union_share(interval, p[:2]) for p in take.parts if p[2] == label), default=0.0)


def _by_motiondb(db: MotionDB, meaning: bool | None = None) -> Finder:
    def find(take: LongTake, interval: tuple[float, float], other: LongTake) -> Found:
        where = f'name="{other.capture.name}"'
        matches = db.like(take.capture.name, *interval, where, limit=1, meaning=meaning)
        return matches[0].score, matches[0].start, matches[0].end

    return find


def _by_warping(whitened: Mapping[str, Float32Array]) -> Finder:
    def find(take: LongTake, interval: tuple[float, float], other: LongTake) -> Found:
        query = _part(whitened[take.capture.name], interval)
        distance, start, end = alignment.best_part(query, whitened[other.capture.name].T)
        return -distance, start / FEATURE_FPS, end / FEATURE_FPS

    return find


def _by_windows(whitened: Mapping[str, Float32Array]) -> Finder:
    """Mean and spread of windows as long as the query, three a second, cosine."""

    def find(take: LongTake, interval: tuple[float, float], other: LongTake) -> Found:
        query = _part(whitened[take.capture.name], interval)
        frames = whitened[other.capture.name]
        low = np.arange(0, max(len(frames) - len(query), 0) + 1, 5)
        rows = np.array([_pooled(frames[a : a + len(query)]) for a in low])
        pooled = _pooled(query)
        cosine = rows @ pooled / (np.linalg.norm(rows, axis=1) * np.linalg.norm(pooled))
        best = int(np.argmax(cosine))
        end = min(int(low[best]) + len(query), len(frames))
        return float(cosine[best]), low[best] / FEATURE_FPS, end / FEATURE_FPS

    return find


def _part(frames: Float32Array, interval: tuple[float, float]) -> Float32Array:
    return frames[round(interval[0] * FEATURE_FPS) : round(interval[1] * FEATURE_FPS)]


def _pooled(frames: Float32Array) -> FloatArray:
    return np.concatenate([frames.mean(axis=0), frames.std(axis=0)]).astype(float)


def _row(judged: Judged, seed: int) -> tuple[Measure, ...]:
    values = (judged.overall, judged.per_take)
    return tuple(
        mean_of([float(v >= share) for v in column], seed) for column in values for share in SHARES
    )


def _notes(judged: Mapping[str, Judged], takes: Sequence[LongTake]) -> tuple[str, ...]:
    """The queries that motiondb answers with less than 0.7."""
    first = next(iter(judged.values()))
    missed = [
        f"{part[2]} of {take.capture.name} ({value:.2f})"
        for (take, part, _), value in zip(questions(takes), first.overall)
        if value < SHARES[-1]
    ]
    return (
        f"Below IoU {SHARES[-1]} over all takes: {', '.join(missed) or 'none'}.",
        "The window and the threshold by which motiondb extends an answer to the whole activity "
        "were chosen among 27 settings on these four takes, because no others have known parts. "
        "Without this step motiondb is as good as subsequence DTW.",
    )


def _by_word(database: Path, takes: Sequence[LongTake], seed: int) -> TaskReport:
    whole, parts = _words_of_wholes(database, takes), _words_of_parts(database, takes, seed)
    labels = {take.capture.name: _labels(take) for take in takes}
    variants, said = interval_places.place_answers(database, takes, labels, WORDS, best_share)
    rows = (
        ("words of whole captures", *_word_row(whole, seed)),
        ("the same, words that the take's own captions say", *_said_row(whole, said, seed)),
        ("the same, the take's own captions left out entirely", *_word_row(variants["left"], seed)),
        ("words of whole captures, places by the word map", *_word_row(variants["map"], seed)),
        ("words of the parts of the other takes", *_word_row(parts, seed)),
    )
    listed = "; ".join(f"{label} in {name} {value:.2f}" for name, label, value in parts)
    return TaskReport(
        "By word",
        "The words of a label are searched in a take that has it; the first interval counts. "
        "Captions of the take itself are never used as evidence, and the interval comes from a "
        "map fitted without this take. *Words of whole captures*: words are learned from the "
        "captions as they are; a caption lists the exercises of a whole take, so `learn` aligns "
        "its words with the segments in the order of the caption. *Left out entirely*: the "
        "take's captions were also not used to align the words of the other takes. *Places by "
        "the word map*: intervals come from the map that ranks captures. *Words of the parts of "
        "the other takes*: the parts of the three other takes have captions, all words of the "
        "searched take are left out, and motiondb learns again for each take; labels that no "
        "other take has are left out.",
        ("words learned from", *(f"R@1, IoU {s}" for s in SHARES), "questions"),
        rows,
        (f"Intersection over union for each question of the last row: {listed}.",),
    )


def _word_row(asked: Sequence[tuple[str, str, float]], seed: int) -> tuple[Measure | int, ...]:
    values = [value for _, _, value in asked]
    return (*(mean_of([float(v >= s) for v in values], seed) for s in SHARES), len(values))


def _said_row(
    asked: Sequence[tuple[str, str, float]], said: Sequence[tuple[str, str]], seed: int
) -> tuple[Measure | int, ...]:
    return _word_row([row for row in asked if row[:2] in said], seed)


def _words_of_wholes(database: Path, takes: Sequence[LongTake]) -> list[tuple[str, str, float]]:
    with motiondb.open(database, read_only=True) as db:
        return [row for take in takes for row in _ask(db, take, _labels(take))]


def _words_of_parts(
    database: Path, takes: Sequence[LongTake], seed: int
) -> list[tuple[str, str, float]]:
    answers = []
    for take in takes:
        others = [t for t in takes if t is not take]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(shutil.copy(database, folder))
            with motiondb.open(path) as db:
                _caption_parts(db, take, others)
                db.learn(LearnSettings(seed=seed))
                known = {label for other in others for label in _labels(other)}
                counts = dict(zip(db.learned.association.words, db.learned.association.counts))
                asked = [
                    label for label in _labels(take)
                    if label in known or all(counts.get(w, 0) > 1 for w in WORDS[label].split())
                ]  # fmt: skip
                answers += _ask(db, take, asked)
    return answers


def _caption_parts(db: MotionDB, take: LongTake, others: Sequence[LongTake]) -> None:
    """Captions of parts for the other takes in place of their own; none for the asked take."""
    for other in others:
        for number, (start, end, label) in enumerate(other.parts):
            db.words.set(other.capture.name, WORDS[label], start, end, keep=number > 0)
    asked = store.load_capture(db.store, take.capture.name).capture_id
    with store.transaction(db.store):
        store.save_captions(db.store, asked, [])


def _ask(db: MotionDB, take: LongTake, labels: Sequence[str]) -> list[tuple[str, str, float]]:
    answers = []
    for label in labels:
        where = f'name="{take.capture.name}"'
        try:
            matches = db.search(WORDS[label], where=where, limit=1, written=False).matches
        except MotionDBError:  # none of the words is known
            matches = ()
        value = best_share(take, label, (matches[0].start, matches[0].end)) if matches else 0.0
        answers.append((take.capture.name, label, value))
    return answers


def _labels(take: LongTake) -> list[str]:
    return sorted({label for _, _, label in take.parts})
