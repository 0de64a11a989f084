"""Which part of a take to label next, where captions list several actions without their times.

Captions of whole takes leave open which part shows which action. A label on one part answers this
for the take, and for all parts of other takes that move alike. The method is that of
:mod:`motiondb.search.suggestion`, with windows of motion in place of captures. The words are known
for windows of takes whose captions name one action, and of labelled intervals. They are uncertain
for windows of takes whose captions list several actions. A suggested part is the chosen window,
extended by neighbouring windows that the label would also describe.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.learn.learned import Learned
from motiondb.meaning.place_fitting import Written, label_intervals, window_vectors
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.search import suggestion

MOST_WINDOWS = 3000
"""Largest number of windows that are compared; of more, every second, third ... is used (memory
is 8 n^2 bytes)."""
MOST_KNOWN = 3000  # Largest number of windows with known words that are compared


@dataclass(frozen=True)
class PartSuggestion:
    """A part of a take that should be labelled next."""

    rank: int  # 1 for the first
    capture: str  # Name of the capture
    start: float
    end: float
    # Share of the uncertainty about parts of takes with several actions that its label would
    # remove, 0 to 1
    gain: float
    listed: tuple[str, ...]  # Words that the captions of the take list
    # Names of other captures with parts that the label would also describe, most seconds first
    like: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Windows:
    """Windows of motion: their vectors (n, columns), captures (n,) and rows of the table (n,)."""

    vectors: FloatArray
    captures: IntArray
    rows: IntArray

    def some(self, keep: IntArray) -> _Windows:
        return _Windows(self.vectors[keep], self.captures[keep], self.rows[keep])


def suggest_parts(learned: Learned, limit: int = 10) -> list[PartSuggestion]:
    """Return parts of takes to label, most informative about other parts first.

    Empty where no caption lists several actions.
    """
    known, unsure = _windows(learned)
    if not len(unsure.rows):
        return []
    unsure, known = _thinned(unsure, MOST_WINDOWS), _thinned(known, MOST_KNOWN)
    table = learned.segments
    seconds = (table.ends - table.starts)[unsure.rows] / MOTION_FPS
    chosen = suggestion.suggest(unsure.vectors, known.vectors, len(seconds), seconds)
    parts: list[PartSuggestion] = []
    taken = np.zeros(len(seconds), dtype=bool)
    for one in chosen:
        if taken[one.index]:
            continue
        inside = _run(unsure, one)
        taken[inside] = True
        parts.append(_part(learned, unsure, one, inside, len(parts) + 1))
        if len(parts) == limit:
            break
    return parts


def _windows(learned: Learned) -> tuple[_Windows, _Windows]:
    """Windows whose action is known from captions, and those of takes that list several."""
    written = Written(learned.captions, learned.synonyms, learned.lemmas, learned.word_numbers)
    known: list[tuple[FloatArray, int, IntArray]] = []
    unsure: list[tuple[FloatArray, int, IntArray]] = []
    for capture, rows in learned.rows.items():
        wholes, parts = written.of_whole(capture), written.of_intervals(capture)
        if not wholes and not parts:
            continue
        vectors = window_vectors(learned.segments, learned.standardised, rows)
        labelled = label_intervals(learned.segments, rows, parts, False, len(learned.word_numbers))
        said = np.zeros(len(vectors), dtype=bool)
        if labelled is not None:
            said = (labelled == 1.0).any(axis=1)
        if wholes and max(map(len, wholes)) < 2:
            said[:] = True
        numbers = np.arange(rows.start, rows.stop)
        known.append((vectors[said], capture, numbers[said]))
        if wholes:
            unsure.append((vectors[~said], capture, numbers[~said]))
    return _joined(known, learned), _joined(unsure, learned)


def _joined(parts: list[tuple[FloatArray, int, IntArray]], learned: Learned) -> _Windows:
    none = np.zeros((0, learned.standardised.shape[1]))
    return _Windows(
        np.concatenate([none, *(vectors for vectors, _, _ in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(np.full(len(v), c) for v, c, _ in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(rows for _, _, rows in parts)]),
    )


def _thinned(windows: _Windows, most: int) -> _Windows:
    step = -(-len(windows.rows) // most)
    return windows if step < 2 else windows.some(np.arange(0, len(windows.rows), step))


def _run(windows: _Windows, one: suggestion.Suggestion) -> IntArray:
    """The chosen window with the neighbouring windows of its take that its label would describe."""
    served = {one.index, *one.served.tolist()}
    of_capture = windows.captures[one.index]
    first = last = one.index
    while first - 1 in served and windows.captures[first - 1] == of_capture:
        first -= 1
    while last + 1 in served and windows.captures[last + 1] == of_capture:
        last += 1
    return np.arange(first, last + 1)


def _part(
    learned: Learned, windows: _Windows, one: suggestion.Suggestion, inside: IntArray, rank: int
) -> PartSuggestion:
    table, number_of_capture = learned.segments, int(windows.captures[one.index])
    seconds: dict[int, float] = {}
    for n in one.served.tolist():
        capture, row = int(windows.captures[n]), windows.rows[n]
        length = float(table.ends[row] - table.starts[row]) / MOTION_FPS
        if capture != number_of_capture:
            seconds[capture] = seconds.get(capture, 0.0) + length
    others = sorted(seconds, key=lambda c: (-seconds[c], c))
    names = learned.association.words
    words = () if learned.places is None else learned.places.words.get(number_of_capture, ())
    info = learned.captures[number_of_capture]
    rows = windows.rows[inside]
    return PartSuggestion(
        rank,
        info.name,
        round(float(table.starts[rows[0]]) / MOTION_FPS, 3),
        round(min(float(table.ends[rows[-1]]) / MOTION_FPS, info.duration), 3),
        round(one.gain, 6),
        tuple(names[w] for w in words),
        tuple(learned.captures[c].name for c in others),
    )
