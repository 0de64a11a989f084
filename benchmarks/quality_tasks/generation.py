"""Motion from sentences: whether it shows the actions, is as smooth as real motion, and is new."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.body import body, retarget
from motiondb.body.contacts import foot_slip
from motiondb.body.features import recognition_features
from motiondb.database import MotionDB
from motiondb.database.catalogue.parts import cut_motion
from motiondb.meaning import alignment
from motiondb.pictures.strip import strip_figure
from motiondb.records import MOTION_FPS, Float32Array, FloatArray, Motion
from motiondb.search.described import describe
from motiondb.symbols import feature_space
from quality_protocol.captures import load_cmu
from quality_protocol.confidence import mean_of
from quality_protocol.judge import CLASSES, Judge, make_judge
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, Picture, TaskReport, draw
from quality_tasks.generation_sentences import measure_sentences

SENTENCES = (
    "walk", "run", "jump", "dance", "climb", "sit", "kick", "box",
    "walk, run", "run, jump", "jump, kick", "kick, box", "walk, sit", "dance, jump",
    "run, walk", "box, jump", "climb, sit", "walk, dance",
    "walk, run, jump", "run, jump, walk", "walk, kick, box", "jump, run, dance",
    "dance, walk, sit", "box, kick, walk",
    "walk, run, jump, walk", "run, kick, box, walk", "walk, dance, jump, run",
    "jump, kick, walk, sit", "walk, jump, run, dance", "run, walk, box, kick",
)  # fmt: skip
"""Thirty sentences of one to four actions."""
METHODS = ("stitched", "trajectory")
REAL = "nearest real clip"
SYNONYMS = {"run": ("run", "jog"), "jump": ("jump", "hop"), "box": ("box", "punch")}
DRAWN = ("walk, kick, box", "run, jump, walk")


@dataclass(frozen=True, eq=False)
class Stretch:
    """One action as shown: its class, motion, and the performers that it was made from."""

    asked: int
    motion: Motion
    performers: frozenset[str]


@dataclass(frozen=True, eq=False)
class Made:
    """A sentence's motion (None if there is none), its actions, and how near it is to stored
    takes (mean whitened feature distance of its three-second parts)."""

    sentence: str
    motion: Motion
    stretches: tuple[Stretch, ...]
    nearest: float


@dataclass(frozen=True)
class Moving:
    """foot slip, cm/s; jerk, m/s^3; speed, m/s; change of bone lengths, mm."""

    slip: float
    jerk: float
    speed: float
    bones: float


def run(data: Path, seed: int) -> TaskReport:
    """Thirty sentences, three methods and the nearest real clip."""
    return measure(learned_database(data, seed), data, seed)


def measure(database: Path, data: Path, seed: int) -> TaskReport:
    """The same on a database that has learned."""
    captures = load_cmu(data)
    space = feature_space.fit_feature_space([c.features for c in captures])
    judge = make_judge(captures, space)
    stored = [space.project(c.features) for c in captures]
    real = [measure_moving(c.motion) for c in captures if c.motion.n_frames >= 30]
    limits = np.quantile([list(vars(m).values()) for m in real], 0.95, axis=0)
    with motiondb.open(database, read_only=True) as db:
        made = {m: [_make(db, s, seed, m, space, stored) for s in SENTENCES] for m in METHODS}
        made[REAL] = [_find(db, s, space, stored) for s in SENTENCES]
        sentences = measure_sentences(db, captures, space, seed)
        rows: list[tuple[str | float | Measure, ...]] = [
            (name, *_recognition(db, judge, column, seed), *_naturalness(column, limits, seed))
            for name, column in made.items()
        ]
    rows.append(_real_row(judge, real, made[METHODS[0]], seed))
    return TaskReport(
        "Generation",
        f"{len(SENTENCES)} sentences of one to four actions out of {len(CLASSES)} "
        f"({', '.join(CLASSES)}); {sum(s.count(',') + 1 for s in SENTENCES)} actions. Every "
        f"action is classified from its frames as one of eight classes (chance "
        f"{1 / len(CLASSES):.3f}): by motiondb (the most probable word of its word map, which also "
        f"chooses trajectories), and by an independent judge, trained on real captures of "
        f"performers other than those whose motion was used (trajectories use no single performer, "
        f"so for them all take part in the training). Last row: real captures of performers that "
        f"the judge was not trained on, every class as often as in the sentences. Medians over "
        f"sentences; *within 95 %*: share of sentences whose foot slip and jerk are at most the "
        f"95th percentile of real captures.",
        (
            "method", "recognised by motiondb", "by logistic regression", "by DTW 1-NN",
            "foot slip, cm/s", "jerk, m/s³", "speed, m/s", "bone change, mm", "within 95 %",
            "distance to the nearest take",
        ),
        tuple(rows),
        (*_limits_note(limits), *_long(made)),
        _draw(made),
        (sentences,),
    )  # fmt: skip


def measure_moving(motion: Motion) -> Moving:
    """How a motion moves: means over frames and joints."""
    positions, _ = retarget.motion_positions(motion)
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * MOTION_FPS
    third = np.diff(positions, 3, axis=0) * MOTION_FPS**3
    parents = np.array(body.PARENTS)
    child = np.flatnonzero(parents >= 0)
    bones = np.linalg.norm(positions[:, child] - positions[:, parents[child]], axis=-1)
    return Moving(
        100.0 * foot_slip(motion),
        float(np.linalg.norm(third, axis=-1).mean()) if len(third) else 0.0,
        float(speed.mean()) if len(speed) else 0.0,
        1000.0 * float(np.ptp(bones, axis=0).max()),
    )


def _make(
    db: MotionDB,
    sentence: str,
    seed: int,
    method: str,
    space: feature_space.FeatureSpace,
    stored: Sequence[Float32Array],
) -> Made:
    made = db.generate(sentence, seed, method)
    performers = {i.name: i.tags.get("performer", "") for i in db.captures()}
    numbers = made.provenance.source_numbers
    whose = [performers.get(s.name, "") for s in made.provenance.sources]
    stretches = []
    for name, (start, end) in zip(sentence.split(", "), made.spans):
        end = min(end, made.motion.n_frames)
        used = {int(n) for n in numbers[start:end] if n >= 0}
        part = cut_motion(made.motion, start / MOTION_FPS, end / MOTION_FPS)
        stretches.append(
            Stretch(list(CLASSES).index(name), part, frozenset(whose[n] for n in used))
        )
    return Made(sentence, made.motion, tuple(stretches), _nearest(made.motion, space, stored))


def _find(
    db: MotionDB,
    sentence: str,
    space: feature_space.FeatureSpace,
    stored: Sequence[Float32Array],
) -> Made:
    """Each action as the best stored interval for its words."""
    performers = {i.name: i.tags.get("performer", "") for i in db.captures()}
    stretches = []
    for name in sentence.split(", "):
        best = db.search(name, limit=1).matches[0]
        part = db.motion(best.capture, best.start, best.end)
        whose = frozenset([performers[best.capture]])
        stretches.append(Stretch(list(CLASSES).index(name), part, whose))
    return Made(
        sentence,
        stretches[0].motion,
        tuple(stretches),
        _nearest(stretches[0].motion, space, stored),
    )


def _nearest(
    motion: Motion, space: feature_space.FeatureSpace, stored: Sequence[Float32Array]
) -> float:
    """Mean over parts of three seconds of the distance to the nearest stored part."""
    features = space.project(recognition_features(motion))
    parts = [features[a : a + 45] for a in range(0, max(len(features) - 45, 0) + 1, 45)]
    return float(np.mean([min(alignment.best_part(p, s.T)[0] for s in stored) for p in parts]))


def heard_class(db: MotionDB, motion: Motion) -> int:
    """The class whose word motiondb finds likeliest, averaged over the motion."""
    totals = dict.fromkeys(CLASSES, 0.0)
    for seconds, words in described_words(db, motion):
        for name in CLASSES:
            said = max(words.get(w, 0.0) for w in SYNONYMS.get(name, (name,)))
            totals[name] += seconds * said
    return int(np.argmax(list(totals.values())))


def described_words(db: MotionDB, motion: Motion) -> list[tuple[float, Mapping[str, float]]]:
    """Seconds and word probabilities of the described intervals of a motion."""
    n_words = len(db.learned.association.words)
    return [
        (d.end - d.start, {word: p for word, p in d.words if p is not None})
        for d in describe(db.learned, motion, n_words)
    ]


def _recognition(
    db: MotionDB, judge: Judge, column: Sequence[Made], seed: int
) -> tuple[Measure, Measure, Measure]:
    stretches = [s for made in column for s in made.stretches]
    asked = np.array([s.asked for s in stretches])
    views = [(judge.space.project(recognition_features(s.motion)), s.performers) for s in stretches]
    heard = np.array([heard_class(db, s.motion) for s in stretches])
    answers = (heard, judge.by_regression(views), judge.by_warping(views))
    ours, regression, warping = (mean_of((a == asked).astype(float), seed) for a in answers)
    return ours, regression, warping


def _naturalness(
    column: Sequence[Made], limits: FloatArray, seed: int
) -> tuple[str | float | Measure, ...]:
    moving = [measure_moving(made.motion) for made in column]
    medians = np.median([list(vars(m).values()) for m in moving], axis=0)
    within = [float(m.slip <= limits[0] and m.jerk <= limits[1]) for m in moving]
    return (
        *(Measure(float(v)) for v in medians), mean_of(within, seed),
        Measure(float(np.median([made.nearest for made in column]))),
    )  # fmt: skip


def _real_row(
    judge: Judge, real: Sequence[Moving], made: Sequence[Made], seed: int
) -> tuple[str | float | Measure, ...]:
    """Real captures of the classes, each judged without its performer, in the mix asked for."""
    views = [(f, frozenset([p])) for f, p in zip(judge.features, judge.performers.tolist())]
    asked = [s.asked for sentence in made for s in sentence.stretches]
    hits = []
    for answers in (judge.by_regression(views), judge.by_warping(views)):
        right = answers == judge.classes
        recall = {c: float(right[judge.classes == c].mean()) for c in np.unique(judge.classes)}
        hits.append(mean_of([recall.get(c, 0.0) for c in asked], seed))
    medians = np.median([list(vars(m).values()) for m in real], axis=0)
    name = f"real captures ({len(views)} judged)"
    return (name, "-", *hits, *(Measure(float(v)) for v in medians), "-", "-")


def _limits_note(limits: FloatArray) -> tuple[str, ...]:
    return (
        f"Real captures' 95th percentile: foot slip {limits[0]:.1f} cm/s, jerk {limits[1]:.0f} "
        f"m/s³, speed {limits[2]:.2f} m/s. Slip is the ground speed of a foot that is low and slow "
        "(the slower of ankle and toe).",
    )


def _long(made: Mapping[str, Sequence[Made]]) -> tuple[str, ...]:
    slow = [m.sentence for m in made[METHODS[0]] if m.motion.n_frames > 20 * MOTION_FPS]
    seconds = [s.motion.n_frames / MOTION_FPS for m in made[METHODS[0]] for s in m.stretches]
    shortest, typical, longest = np.quantile(seconds, (0.0, 0.5, 1.0))
    note = (
        f"Stitched actions last {typical:.1f} s in the median, from {shortest:.1f} to "
        f"{longest:.1f} s; sentences longer than 20 s: {'; '.join(slow) or 'none'}."
    )
    return (note,)


def _draw(made: Mapping[str, Sequence[Made]]) -> tuple[Picture, ...]:
    drawn = []
    for sentence in DRAWN:
        motion = next(m.motion for m in made[METHODS[0]] if m.sentence == sentence)
        figure = strip_figure(motion, title=sentence)
        name = f"quality-generation-{sentence.replace(', ', '-')}.png"
        drawn.append(draw(figure, name, f"Generated: {sentence}"))
    return tuple(drawn)
