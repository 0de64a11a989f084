"""Boundaries of short actions: told intervals against intervals that were marked by looking.

``marked_intervals.tsv`` was made from strips of stick figures, ten a second, with the height of the
toes below: a jump from take-off to landing, a kick from the lifting of the foot to its return, a
punch from the start of the hand to its return, ducking and standing up from the first to the last
bending, a shot from raising the ball to lowering the arms. All intervals of a word in a capture are
marked. Nothing is learned from the marks, but settings of ``motiondb.meaning.edge_map`` were chosen
 with them in view.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb.database import MotionDB
from motiondb.errors import MotionDBError
from motiondb.learn.recognition import LearnSettings
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import search_words
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, TaskReport

MARKS = Path(__file__).with_name("marked_intervals.tsv")
SAMPLE = Path(__file__).resolve().parents[2] / "sample_data"
SHORT = (
    "bow", "jump", "kick", "punch", "duck", "parry", "push", "block", "feint", "catch", "pass",
    "shoot", "sit_down", "stand_up", "pick_up", "turn_left", "turn_right",
)  # fmt: skip
"""Labels of the sample data that name a short action."""
NEAR = 0.3
"""Seconds within which a boundary is right."""
N_DRAWS = 2000
"""Bootstrap samples of an interval. Chosen by hand; not tuned."""

Span = tuple[float, float]
Marked = Mapping[tuple[str, str], Sequence[Span]]
"""Capture and word -> its intervals, rising."""


@dataclass(frozen=True)
class Asked:
    """One question: distances of both boundaries, refined and of segments, in seconds."""

    capture: str
    word: str
    refined: Span
    segments: Span


def run(data: Path, seed: int) -> TaskReport:
    """Real captures by performer and by word, and sample data."""
    return measure(learned_database(data, seed), seed)


def measure(database: Path, seed: int) -> TaskReport:
    """The same on a database that has learned CMU."""
    marked = read_marks(MARKS)
    with motiondb.open(database, read_only=True) as db:
        real = ask(db, marked)
    with (
        tempfile.TemporaryDirectory() as folder,
        motiondb.open(Path(folder) / "sample.duckdb") as db,
    ):
        db.add(SAMPLE / "captures", SAMPLE / "captions.tsv")
        db.learn(LearnSettings(seed=seed))
        made = ask(db, _sample_marks())
    rows: list[tuple[str | float | Measure, ...]] = [("real captures", *_row(real, seed))]
    rows += _grouped("performer", real, lambda one: one.capture.split("/")[0], seed)
    rows += _grouped("word", real, lambda one: one.word, seed)
    rows.append(("sample data (synthetic)", *_row(made, seed)))
    n = sum(len(spans) for spans in marked.values())
    return TaskReport(
        "Boundaries of short actions",
        f"{n} intervals of short actions were marked by looking at strips of stick figures of "
        f"{len({capture for capture, _ in marked})} CMU captures (a jump from take-off to "
        "landing). Each word is asked of each capture with marks; the first interval counts, "
        "and the capture's captions are not used as evidence. Its boundaries are compared with "
        "the run of successive marks (one action, or several with what lies between) that they "
        "are closest to. *Segments*: the same answers with the boundaries of segments. "
        "Captions of the asked capture took part in learning, as in any database. Intervals are "
        "over questions.",
        ("asked of", "questions", "median error, s", "segments: median error, s",
         f"within {NEAR} s", f"segments: within {NEAR} s"),
        tuple(rows),
        notes=_NOTES,
    )  # fmt: skip


_NOTES = (
    "The figures are optimistic: the rule that refines the boundaries, and `NARROW` in "
    "`motiondb/search/placing.py` (activities that fill more than three fifths of their "
    "interval keep the boundaries of segments), were chosen with these marks in view.",
    'If the wrong part of a capture is found, no boundary can be right. "Stand up" is found '
    "where performer 14 sits down (he sits down and stands up twice in most takes, and the "
    'captions list both once), and "hop" in the steps before the hop (two captures of one '
    "performer have the word).",
    "On the sample data the intervals are too short. There an action lasts from leaving the "
    "stance to the return to it, so a jump includes the bending before it and the recovery "
    "after it; the marks of real jumps go from take-off to landing. No single threshold fits "
    "both.",
)


def read_marks(path: Path) -> dict[tuple[str, str], list[Span]]:
    """Capture and word -> marked intervals (seconds), rising."""
    marked: dict[tuple[str, str], list[Span]] = {}
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            span = (float(row["start_s"]), float(row["end_s"]))
            marked.setdefault((row["capture"], row["word"]), []).append(span)
    return {key: sorted(spans) for key, spans in marked.items()}


def ask(db: MotionDB, marked: Marked) -> list[Asked]:
    """Ask every word of every capture with marks; words that are not known are left out."""
    learned = db.learned
    numbers = {info.name: capture for capture, info in learned.captures.items()}
    frames = db.session.frames
    both = (learned, replace(learned, edges=None))
    asked = []
    for (capture, word), spans in marked.items():
        asked_parts = []
        for of in both:
            try:
                answer = search_words(
                    understand_learned(of, word, looks_at_motion=True),
                    [numbers[capture]],
                    1,
                    written=False,
                    frames=frames,
                )
            except MotionDBError:  # the word is not known
                break
            asked_parts += [(match.start, match.end) for match in answer.matches[:1]]
        if len(asked_parts) == 2:
            refined, segments = (closest(spans, told) for told in asked_parts)
            asked.append(Asked(capture, word, refined, segments))
    return asked


def closest(spans: Sequence[Span], told: Span) -> Span:
    """Distances of the boundaries of an interval from those of the run of marks closest to it.

    >>> closest([(1.0, 2.0), (4.0, 5.0)], (1.5, 5.25))
    (0.5, 0.25)
    """
    runs = [(spans[i][0], spans[j][1]) for i in range(len(spans)) for j in range(i, len(spans))]
    apart = [(abs(told[0] - start), abs(told[1] - end)) for start, end in runs]
    return min(apart, key=sum)


def _sample_marks() -> dict[tuple[str, str], list[Span]]:
    marked: dict[tuple[str, str], list[Span]] = {}
    with (SAMPLE / "segments.tsv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            if row["label"] in SHORT:
                span = (float(row["start_s"]), float(row["end_s"]))
                name = row["file"].rsplit(".", 1)[0]
                marked.setdefault((name, row["label"].replace("_", " ")), []).append(span)
    return {key: sorted(spans) for key, spans in marked.items()}


def _grouped(
    kind: str, asked: Sequence[Asked], of: Callable[[Asked], str], seed: int
) -> list[tuple[str | float | Measure, ...]]:
    names = dict.fromkeys(map(of, asked))
    return [
        (f"{kind} {name}", *_row([one for one in asked if of(one) == name], seed)) for name in names
    ]


def _row(asked: Sequence[Asked], seed: int) -> tuple[int | Measure, ...]:
    refined, segments = (
        np.array([getattr(one, name) for one in asked]).reshape(-1, 2)
        for name in ("refined", "segments")
    )
    draws = np.random.default_rng(seed).integers(len(asked), size=(N_DRAWS, len(asked)))

    def measured(errors: np.ndarray, of: Callable[[np.ndarray], float]) -> Measure:
        low, high = np.quantile([of(errors[draw]) for draw in draws], [0.025, 0.975])
        return Measure(of(errors), float(low), float(high), 2)

    def median(errors: np.ndarray) -> float:
        return float(np.median(errors))

    def near(errors: np.ndarray) -> float:
        return float((errors <= NEAR + 1e-9).mean())

    return (
        len(asked), measured(refined, median), measured(segments, median),
        measured(refined, near), measured(segments, near),
    )  # fmt: skip
