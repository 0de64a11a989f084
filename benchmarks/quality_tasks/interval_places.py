"""Places of words learned from captions of whole takes: variants, and their predicted
certainties."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import motiondb
from motiondb.errors import MotionDBError
from motiondb.language import vocabulary
from motiondb.learn.learned import Learned
from motiondb.meaning import place_fitting
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import search_words
from quality_protocol.takes import LongTake

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
        Capture -> the labels searched in it.
    words : mapping of str to str
        Label -> the words of the question.
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


def _first(learned: Learned, text: str, capture: int) -> tuple[float, float] | None:
    try:
        matches = search_words(
            understand_learned(learned, text), [capture], limit=1, written=False
        ).matches
    except MotionDBError:  # none of the words is known
        return None
    return (matches[0].start, matches[0].end) if matches else None


def _written(learned: Learned, without: int | None = None) -> place_fitting.Written:
    captions = {c: rows for c, rows in learned.captions.items() if c != without}
    return place_fitting.Written(captions, learned.synonyms, learned.lemmas, learned.word_numbers)


def _places_without(learned: Learned, capture: int) -> place_fitting.Places | None:
    """Places found as if a capture had no caption."""
    return place_fitting.find_places(
        learned.segments, learned.segment_rows[:], _written(learned, capture)
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
