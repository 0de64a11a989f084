"""Places of words when one part of one take is labelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import motiondb
from motiondb.learn.learned import Learned
from motiondb.meaning.place_fitting import Written, find_places
from motiondb.records import Caption
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import search_words
from quality_protocol.captures import load_cmu
from quality_protocol.confidence import mean_of
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, TaskReport
from quality_protocol.takes import LongTake, load_takes
from quality_tasks.interval import SHARES, WORDS, best_share

TAKE, LABEL = "14/14_20", "KneeRaise"
"""The part that is labelled."""


def run(data: Path, seed: int) -> TaskReport:
    """The questions of *By word*, before and after one label."""
    return measure(learned_database(data, seed), data, seed)


def measure(database: Path, data: Path, seed: int) -> TaskReport:
    """The same on a database that has learned."""
    takes = load_takes(data, load_cmu(data))
    (take,) = (take for take in takes if take.capture.name == TAKE)
    (span,) = ((start, end) for start, end, label in take.parts if label == LABEL)
    with motiondb.open(database, read_only=True) as db:
        learned = db.learned
    after = _labelled(learned, TAKE, LABEL, span)
    shown = f"{LABEL}, {TAKE} {span[0]:.1f}-{span[1]:.1f} s"
    rows = (
        ("no label", "", *_row(learned, takes, seed)),
        ("one part labelled", shown, *_row(after, takes, seed)),
        ("one part labelled, its own label counts", shown, *_row(after, takes, seed, TAKE)),
    )
    return TaskReport(
        "By word, with one part labelled",
        "The questions of *By word*, with boundaries of segments. One part of one long take is "
        "labelled with the words of its true label. Captions of the searched take are not used "
        "as evidence, because they would reveal the labelled part. The other takes learn from "
        "the label, and their map finds the words in the labelled take too. *Its own label "
        "counts*: the label is also used directly in that take.",
        ("labelled", "part", *(f"R@1, IoU {s}" for s in SHARES), "questions"),
        rows,
    )


def _labelled(learned: Learned, capture: str, label: str, span: tuple[float, float]) -> Learned:
    """What would have been learned with one more caption; the vocabulary stays."""
    number = next(n for n, info in learned.captures.items() if info.name == capture)
    captions = {**learned.captions}
    captions[number] = (*captions.get(number, ()), Caption(WORDS[label], *span))
    written = Written(captions, learned.synonyms, learned.lemmas, learned.word_numbers)
    places = find_places(learned.segments, learned.segment_rows[:], written)
    return replace(learned, captions=captions, places=places)


def _shares(learned: Learned, takes: Sequence[LongTake], labelled: str = "") -> list[float]:
    """Intersection over union of every question; captions count in the take ``labelled``."""
    numbers = {info.name: capture for capture, info in learned.captures.items()}
    shares = []
    for take in takes:
        name = take.capture.name
        for label in sorted({label for _, _, label in take.parts}):
            matches = search_words(
                understand_learned(learned, WORDS[label]),
                [numbers[name]],
                1,
                written=name == labelled,
            ).matches
            told = [(match.start, match.end) for match in matches]
            shares.append(best_share(take, label, told[0]) if told else 0.0)
    return shares


def _row(
    learned: Learned, takes: Sequence[LongTake], seed: int, labelled: str = ""
) -> tuple[Measure | int, ...]:
    shares = _shares(learned, takes, labelled)
    return (*(mean_of([float(v >= s) for v in shares], seed) for s in SHARES), len(shares))
