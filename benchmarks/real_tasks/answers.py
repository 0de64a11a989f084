"""Ask the real captures everything in ``questions``, judge the answers, draw them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from PIL import Image

from motiondb import pictures
from motiondb.database import MotionDB, generated_files
from motiondb.database.generating import Generated
from motiondb.generate.motion_making import METHODS
from motiondb.generate.shown_actions import JudgedAction
from motiondb.records import Match, Motion
from motiondb.search.takings import Sentence
from real_tasks.measures import (
    Part,
    Smoothness,
    hears_unseen_performers,
    overlap,
    said_words,
    search_takes,
    smoothness,
    union_overlap,
)
from real_tasks.notes import Notes
from real_tasks.questions import EXAMPLES, PARTS, SEED, SENTENCES, WORDS, Example

FIRST = 5
"""Answers that are shown and judged."""


@dataclass(frozen=True)
class Judged:
    """A hit; right: "yes", "no" or "half"; looked: a person has looked at it."""

    match: Match
    right: str
    looked: bool


@dataclass(frozen=True)
class WordResult:
    """First answers to words: with written words, by motion alone, by motion of unseen performers.

    there : how many captures would be right.
    """

    words: str
    unknown: tuple[str, ...]
    there: int
    written: tuple[Judged, ...]
    alone: tuple[Judged, ...]
    unseen: tuple[Judged, ...]
    picture: str


@dataclass(frozen=True)
class ExampleResult:
    """First answers to an example besides itself, from everybody and from other performers.

    itself : the answer at rank 1, which should be the example.
    """

    example: Example
    itself: Match
    everybody: tuple[Judged, ...]
    others: tuple[Judged, ...]
    picture: str


@dataclass(frozen=True)
class MadeResult:
    """A generated motion.

    methods : by every method, smoothness and how the symbols that it was made from are recognised
        again: "exactly", "merged" (exactly once repeats are merged) or "otherwise".
    shown : by every method, what the judge says of every action.
    """

    sentence: str
    made: Generated
    methods: dict[str, tuple[Smoothness, str]]
    shown: dict[str, tuple[JudgedAction, ...]]
    described: tuple[str, ...]
    picture: str


def slug(text: str) -> str:
    """A file name.

    >>> slug("run, turn left")
    'run-turn-left'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def shrink(path: Path, colours: int = 48) -> Path:
    """Store a picture with a palette, which takes a third of the room."""
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(colours, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
    return path


def ask_words(db: MotionDB, notes: dict[str, Notes], folder: Path) -> list[WordResult]:
    """All word questions."""
    learned = db.learned
    said = said_words(learned)
    unseen = hears_unseen_performers(learned)
    results = []
    for words in WORDS:
        query = Sentence(learned, words).in_known_words({})
        verdicts = notes.get(f"words: {words}", Notes()).verdicts
        asked = set(query.words)

        def judge(match: Match, asked: set[str] = asked, verdicts: dict = verdicts) -> Judged:
            if match.capture in verdicts:
                return Judged(match, verdicts[match.capture][0], True)
            return Judged(match, "yes" if asked <= said[match.capture] else "no", False)

        written = db.search(words, limit=FIRST)
        alone = db.search(words, limit=FIRST, written=False).matches
        blind = search_takes(learned, unseen, words, FIRST)
        there = sum(judge(Match(0, name, 0.0, 0.0, 0.0)).right == "yes" for name in said)
        picture = _draw(db, written.matches, folder / f"words-{slug(words)}.png", words)
        with_words, by_motion, by_unseen = (
            tuple(map(judge, hits)) for hits in (written.matches, alone, blind)
        )
        results.append(
            WordResult(
                words, tuple(query.unknown), there, with_words, by_motion, by_unseen, picture
            )
        )
    return results


def ask_examples(
    db: MotionDB, parts: dict[str, list[Part]], notes: dict[str, Notes], folder: Path
) -> list[ExampleResult]:
    """All questions by example; the example itself is not counted among the answers."""
    said = said_words(db.learned)
    results = []
    for example in EXAMPLES:
        judge = _example_judge(example, said, parts, notes)
        matches = db.like(example.capture, example.start, example.end, limit=FIRST + 2)
        performer = example.capture.split("/")[0]
        foreign = db.like(
            example.capture,
            example.start,
            example.end,
            where=f"performer != '{performer}'",
            limit=FIRST,
        )
        shown = [m for m in matches if not _is_itself(m, example)][:FIRST]
        motion = db.motion(example.capture, example.start, example.end)
        target = folder / f"like-{slug(example.name)}.png"
        picture = _draw(db, shown, target, f"like {example.name}", (example.capture, motion))
        results.append(
            ExampleResult(
                example, matches[0], tuple(map(judge, shown)), tuple(map(judge, foreign)), picture
            )
        )
    return results


def _example_judge(
    example: Example,
    said: dict[str, frozenset[str]],
    parts: dict[str, list[Part]],
    notes: dict[str, Notes],
) -> Callable[[Match], Judged]:
    verdicts = notes.get(f"like: {example.name}", Notes()).verdicts

    def judge(match: Match) -> Judged:
        if match.capture in parts:
            share = overlap(match.start, match.end, parts[match.capture], example.labels)
            return Judged(match, "yes" if share >= 0.5 else "no", False)
        if match.capture in verdicts:
            return Judged(match, verdicts[match.capture][0], True)
        right = bool(said[match.capture] & set(example.words))
        return Judged(match, "yes" if right else "no", False)

    return judge


def _is_itself(match: Match, example: Example) -> bool:
    if match.capture != example.capture:
        return False
    start, end = example.start or 0.0, example.end or float("inf")
    shared = min(end, match.end) - max(start, match.start)
    return shared > 0.5 * (match.end - match.start)


def find_parts(
    db: MotionDB, parts: dict[str, list[Part]]
) -> list[tuple[str, Match, float, Part | None]]:
    """(words, found interval, intersection over union, nearest true part) in the long takes.

    Captions of a long take speak of the whole; the interval comes from the motion.
    """
    rows = []
    for words, labels in PARTS:
        for capture, known in sorted(parts.items()):
            if any(label in labels for _, _, label in known):
                match = db.search(words, where=f"name = '{capture}'", limit=1).matches[0]
                share, part = union_overlap(match.start, match.end, known, labels)
                rows.append((words, match, share, part))
    return rows


def make_sentences(db: MotionDB, folder: Path) -> list[MadeResult]:
    """All sentences, by all methods; pictures of the first."""
    results = []
    for sentence in SENTENCES:
        made = {method: db.generate(sentence, SEED, method) for method in METHODS}
        best = made[METHODS[0]]
        described = db.describe(best.motion)
        spans = [
            (d.start, d.end, " ".join(w for w, _ in d.words[:2]), d.words[0][0]) for d in described
        ]
        timelines = [
            pictures.Timeline("sources", generated_files.source_spans(best)),
            pictures.Timeline("recognised", spans),
        ]
        target = folder / f"made-{slug(sentence)}.png"
        pictures.save_png(pictures.strip_figure(best.motion, sentence, timelines), target)
        methods = {name: (smoothness(g.motion), _recognised(g)) for name, g in made.items()}
        words = tuple(f"{span[2]} {span[0]:.1f}–{span[1]:.1f} s" for span in spans)
        shown = {name: g.shown for name, g in made.items()}
        results.append(MadeResult(sentence, best, methods, shown, words, shrink(target).name))
    return results


def _recognised(made: Generated) -> str:
    if made.symbols == made.recognised:
        return "exactly"
    asked, recognised = ([s for s, _ in groupby(row)] for row in (made.symbols, made.recognised))
    return "merged" if asked == recognised else "otherwise"


def measure_captures(db: MotionDB) -> list[Smoothness]:
    """Slip and jerk of every stored capture."""
    return [smoothness(db.motion(info.name)) for info in db.captures()]


def median_smoothness(values: Sequence[Smoothness]) -> Smoothness:
    """The median of each measure."""
    rows = np.array([(v.slip, v.jerk, v.seconds) for v in values])
    return Smoothness(*np.median(rows, axis=0).tolist())


def _draw(
    db: MotionDB,
    matches: Sequence[Match],
    target: Path,
    title: str,
    query: tuple[str, Motion] | None = None,
) -> str:
    hits = [(match, db.motion(match.capture)) for match in matches]
    pictures.save_png(pictures.hits_figure(hits, title, query), target)
    return shrink(target).name
