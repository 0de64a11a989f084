"""Sentences over all actions that three or more captures show: does the motion show them?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import recognition_features
from motiondb.database import MotionDB
from motiondb.database.catalogue.parts import cut_motion
from motiondb.database.generating import Generated
from motiondb.errors import QueryError
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.symbols.feature_space import FeatureSpace
from quality_protocol.action_recogniser import (
    Models,
    Recogniser,
    capture_folds,
    fold_models,
    make_recogniser,
    performer_folds,
)
from quality_protocol.captures import Capture
from quality_protocol.confidence import mean_of
from quality_protocol.report import Measure, TaskReport

ACTIONS = (
    ("walk", r"\bwalk"), ("run", r"\brun"), ("jog", r"\bjog"), ("jump", r"\bjump"),
    ("hop", r"\bhop"), ("dance", r"\bdanc"), ("salsa", r"\bsalsa"), ("climb", r"\bclimb"),
    ("sit", r"\bsit"), ("stand", r"\bstand"), ("kick", r"\bkick"), ("turn", r"\bturn"),
    ("veer", r"\bveer"), ("stop", r"\bstop"), ("twist", r"\btwist"), ("swing", r"\bswing"),
    ("hang", r"\bhang"), ("dangle", r"\bdangl"), ("bend", r"\bbend"), ("reach", r"\breach"),
    ("grab", r"\bgrab"), ("wash", r"\bwash"), ("drink", r"\bdrink"), ("laugh", r"\blaugh"),
    ("wave", r"\bwav"), ("point", r"\bpoint\b"), ("direct", r"\bdirect\b"),
    ("dribble", r"\bdribbl"), ("duck", r"\bduck"), ("step", r"\bstep(s|ping)?\b"),
    ("flip", r"\bflip"), ("arabesque", r"\barabesque"), ("jete", r"\bjete"),
    ("pirouette", r"\bpirouette"), ("tiptoe", r"\btiptoe"), ("start", r"\bstart"),
)  # fmt: skip
"""Actions that three or more captures show, and how captions say them."""
JOINED = (
    "walk, then run", "run, then jump", "jump, then walk", "walk, then sit", "walk, then stop",
    "run, then stop", "sit, then stand up", "jog, then walk", "dance, then walk", "walk, then kick",
    "climb, then jump", "walk, then dance", "run, then duck", "dribble, then walk",
    "wash, then walk", "walk, then drink", "walk, run, jump", "sit, stand up, walk",
)  # fmt: skip
"""Sentences of two and three actions."""
AMOUNTS = (
    "jump three times", "kick twice", "walk for ten seconds", "walk slowly", "run fast",
    "walk fast", "dribble for eight seconds", "dance for twelve seconds", "walk backward",
    "turn left", "turn right", "sit down",
)  # fmt: skip
"""Sentences with counts, durations, speeds and directions."""
Motions = Mapping[str, Generated | None]
"""Sentence -> its motion; None if it was refused."""
SENTENCES = (*(word for word, _ in ACTIONS), *JOINED, *AMOUNTS)


@dataclass(frozen=True, eq=False)
class Outcome:
    """One action of one sentence: asked word, its windows, its sources, the one of most frames (-1:
    none), and what the judge says."""

    sentence: str
    asked: int
    windows: FloatArray
    captures: frozenset[int]
    source: int
    shown: bool | None
    probability: float | None


def measure_sentences(
    db: MotionDB, captures: Sequence[Capture], space: FeatureSpace, seed: int
) -> TaskReport:
    """Recognition, the judge's calibration, amounts, and how far seeds differ."""
    made = {sentence: generate_or_none(db, sentence, seed) for sentence in SENTENCES}
    again = {word: generate_or_none(db, word, seed + 1) for word, _ in ACTIONS}
    return evaluate(make_recogniser(captures, ACTIONS, space), made, again, seed)


def evaluate(of: Recogniser, made: Motions, again: Motions, seed: int) -> TaskReport:
    """The report of motions; ``again``: those of single actions with another seed."""
    outcomes = [one for s, g in made.items() if g is not None for one in _outcomes(of, s, g)]
    rows: list[tuple[str | float | Measure, ...]] = []
    rng = np.random.default_rng(seed)
    told: list[tuple[float, bool]] = []
    for name, folds in (
        ("its captures left out", capture_folds(of, rng)),
        ("its performers left out", performer_folds(of)),
    ):
        models = fold_models(of, folds)
        firsts = [_first(of, models, folds, one) for one in outcomes]
        hits = [_same(of, first, one.asked) for first, one in zip(firsts, outcomes)]
        named = [
            hit or (one.source >= 0 and bool(of.one_action[one.source, first, one.asked]))
            for hit, first, one in zip(hits, firsts, outcomes)
        ]
        real = _real(of, models, folds, [o.asked for o in outcomes])
        told = told or [(o.probability, h) for o, h in zip(outcomes, hits) if o.probability]
        said = [hit for one, hit in zip(outcomes, hits) if one.shown]
        unsaid = [hit for one, hit in zip(outcomes, hits) if not one.shown]
        rows.append(
            (
                name, mean_of([float(h) for h in hits], seed), mean_of(real[0], seed),
                mean_of([float(h) for h in named], seed), mean_of(real[1], seed),
                mean_of(real[2], seed),
                mean_of([float(h) for h in said], seed), mean_of([float(h) for h in unsaid], seed),
            )
        )  # fmt: skip
    return TaskReport(
        "Generation: all actions",
        f"{len(SENTENCES)} sentences over the {len(ACTIONS)} actions that three or more captures "
        f"show ({', '.join(word for word, _ in ACTIONS)}), with orders, counts, durations, speeds "
        f"and directions; {len(outcomes)} actions were made. An independent recogniser (one "
        "logistic regression per word, on pooled windows of the real captures) gives the most "
        "probable word of every action's frames; it is right if this action was requested, or if "
        "the captions never separate the two words. *Or its other name*: right also if a caption "
        "of the source names one action by both words (run/jog, salsa dance). *Real*: the same for "
        "captures whose captions say the action, every action as often as the sentences ask for "
        "it; *any of its caption*: the first word is one of those that the caption says. *Said to "
        "be shown*: the actions that motiondb's judge says are shown.",
        ("recogniser", "first word right", "real", "or its other name", "real, or other name",
         "real, any of its caption", "said to be shown", "said not to be"),
        tuple(rows),
        (_say_judge(outcomes), _say_calibration(told), _say_seeds(made, again),
         _say_amounts(made)),
    )  # fmt: skip


def generate_or_none(db: MotionDB, sentence: str, seed: int) -> Generated | None:
    """A motion; None if nothing shows the sentence."""
    try:
        return db.generate(sentence, seed)
    except QueryError:
        return None


def _outcomes(of: Recogniser, sentence: str, made: Generated) -> list[Outcome]:
    numbers = {name: n for n, name in enumerate(of.names)}
    sources = [numbers.get(s.name, -1) for s in made.provenance.sources]
    outcomes = []
    for one in made.shown:
        asked = [of.words.index(word) for word in one.words if word in of.words]
        if not asked or one.end <= one.start:
            continue
        part = cut_motion(made.motion, one.start / MOTION_FPS, one.end / MOTION_FPS)
        numbers_of = made.provenance.source_numbers[one.start : one.end]
        used = {sources[int(n)] for n in numbers_of}
        main = sources[int(np.argmax(np.bincount(numbers_of)))]
        outcomes.append(
            Outcome(
                sentence, asked[0], of.view(recognition_features(part)), frozenset(used),
                main, one.shown, one.probability,
            )
        )  # fmt: skip
    return outcomes


def _same(of: Recogniser, first: int, asked: int) -> bool:
    """Whether a word is the asked one, or captions say both of the same captures only."""
    return bool((of.said[:, first] == of.said[:, asked]).all())


def _first(of: Recogniser, models: Sequence[Models], folds: IntArray, one: Outcome) -> int:
    """The first word, by the models without all sources."""
    gone = sorted({int(folds[c]) for c in one.captures if c >= 0})
    if len(gone) == 1:
        return models[gone[0]].first(one.windows)
    out = np.flatnonzero(np.isin(folds, gone))
    return of.fit(out).first(one.windows)


def _real(
    of: Recogniser, models: Sequence[Models], folds: IntArray, asked: Sequence[int]
) -> tuple[list[float], list[float], list[float]]:
    """Shares of the real captures of every requested action whose first word is right.

    That is the action, the action or another name of it, or any word of the caption.
    """
    n_captures = len(of.names)
    first = np.array(
        [models[int(folds[c])].first(of.windows[of.owners == c]) for c in range(n_captures)]
    )
    shares: tuple[list[float], list[float], list[float]] = ([], [], [])
    for word in asked:
        saying = np.flatnonzero(of.said[:, word])
        itself = np.array([_same(of, int(first[c]), word) for c in saying])
        named = itself | of.one_action[saying, first[saying], word]
        for share, right in zip(shares, (itself, named, of.said[saying, first[saying]])):
            share.append(float(right.mean()))
    return shares


def _say_judge(outcomes: Sequence[Outcome]) -> str:
    counts = [sum(o.shown is value for o in outcomes) for value in (True, False, None)]
    return (
        f"motiondb's judge says that {counts[0]} actions are shown, that {counts[1]} are not, and "
        f"that {counts[2]} cannot be confirmed."
    )


def _say_calibration(told: Sequence[tuple[float, bool]]) -> str:
    """Predicted probabilities compared with the share that the recogniser finds right (captures
    left out)."""
    probability = np.array([p for p, _ in told])
    hit = np.array([h for _, h in told], dtype=float)
    parts = []
    for low, high in ((0.0, 0.3), (0.3, 0.6), (0.6, 0.9), (0.9, 1.01)):
        inside = (probability >= low) & (probability < high)
        if inside.any():
            parts.append(
                f"{probability[inside].mean():.2f} reported, {hit[inside].mean():.2f} confirmed "
                f"({int(inside.sum())} actions)"
            )
    return (
        "Reported probability, and the share that the recogniser without the captures confirms: "
        + "; ".join(parts)
        + "."
    )


def _say_seeds(made: Motions, again: Motions) -> str:
    """How many sentences give another motion with another seed."""
    pairs = [(made[word], two) for word, two in again.items()]
    both = [(one, two) for one, two in pairs if one is not None and two is not None]
    other = sum(
        one.motion.n_frames != two.motion.n_frames
        or not np.array_equal(one.motion.local_rotations, two.motion.local_rotations)
        for one, two in both
    )
    sources = sum(
        {s.name for s in one.provenance.sources} != {s.name for s in two.provenance.sources}
        for one, two in both
    )
    return (
        f"Another seed gives another motion for {other} of the {len(both)} single actions, from "
        f"another capture for {sources}."
    )


def _say_amounts(made: Motions) -> str:
    told = []
    for sentence in AMOUNTS:
        one = made[sentence]
        if one is not None:
            left = [f"{left.text!r} not honoured" for left in one.not_used]
            done = [line for shown in one.shown for line in shown.done[1:]]
            told.append(f"*{sentence}*: {one.motion.n_frames / MOTION_FPS:.1f} s"
                        + "".join(f", {text}" for text in (*done, *left)))  # fmt: skip
    refused = [sentence for sentence, one in made.items() if one is None]
    return "; ".join(told) + f". Refused: {'; '.join(refused) or 'none'}."
