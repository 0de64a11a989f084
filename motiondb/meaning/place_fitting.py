"""The places of the captions' actions in their takes, which ``learn`` estimates and stores.

**Captions of whole takes** are aligned with the segments (:mod:`motiondb.meaning.place_map`).
**Captions of intervals** give the place: their words are shown at the segments of which at least
half is in the interval, and nowhere else in a take without a caption for the whole. Other words
that captions of the take list are not shown there, and their words are not shown by the segments
beside the interval.

The result is y, the probability that each listed word is shown at each segment of a take. One ridge
regression on y gives the map, and also the evidence for every take from the map without that take.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from motiondb.language import vocabulary
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.motion_judge import Said
from motiondb.meaning.place_map import (
    LABELLED,
    RIDGE,
    FittedPlaces,
    ListedTakes,
    PlaceMap,
    find_shown,
    take_weights,
)
from motiondb.meaning.regression import Fitted, MadeRows, Regression
from motiondb.meaning.score_vectors import Rows, window_vectors_of
from motiondb.meaning.word_evidence import WINDOW_MARGIN, TakeScores
from motiondb.records import MOTION_FPS, Caption, Float32Array, FloatArray, IntArray, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread

Actions = list[list[int]]  # Word numbers of every action, in order
Room = Callable[[tuple[int, int], Any], Any]
"""Makes an array of a shape and type: in memory, or in a file."""
FITTED_AT_ONCE = 2048  # Segments whose products are summed at once; by hand
LEAST_INFERRED = 0.01  # Least y of an inferred word that is kept; less hardly changes the map


def label_intervals(
    table: SegmentTable,
    rows: slice,
    parts: Sequence[tuple[Caption, Actions]],
    nowhere_else: bool,
    n_words: int,
) -> FloatArray | None:
    """y (segments, words) that captions of intervals give; None without any."""
    if not parts:
        return None
    starts, ends = table.starts[rows], table.ends[rows]
    labelled = np.full((len(starts), n_words), np.nan)
    words = sorted({word for _, actions in parts for action in actions for word in action})
    if nowhere_else:
        labelled[:, words] = 0.0
    for caption, actions in parts:
        low = (caption.start or 0.0) * MOTION_FPS
        high = float(ends[-1]) if caption.end is None else caption.end * MOTION_FPS
        shared = np.minimum(ends, high) - np.maximum(starts, low)
        inside = 2.0 * shared >= ends - starts
        if not inside.any():  # shorter than half of every segment that it meets
            inside = shared == shared.max()
        for word in {word for action in actions for word in action}:
            labelled[inside, word] = 1.0
    return labelled


def complete_labels(labelled: FloatArray, listed: Sequence[set[int]]) -> None:
    """Set y to 0, in place, where labels imply that a word is not shown.

    A labelled interval lasts from the begin to the end of its action, so that the segments before
    and after it do not show it; nor does it show other actions that captions of the take list. A
    listed action with a word more or less than the label ("side twist", "twist") may be the same.
    The segments before and after may show other listed actions that share words with the label.

    Shapes: `labelled` (segments, words).
    """
    labels = [set(np.flatnonzero(row == 1.0).tolist()) for row in labelled]
    for row, label in enumerate(labels):
        if not label:
            continue
        same = [action for action in listed if action <= label or action >= label]
        others = set().union(*(action for action in listed if action not in same))
        _set_unknown(labelled[row], set().union(*listed).difference(*same))
        for beside in (row - 1, row + 1):
            if 0 <= beside < len(labels):
                _set_unknown(labelled[beside], label - others - labels[beside])


def _set_unknown(y: FloatArray, words: set[int]) -> None:
    """Set y to 0, in place, for those of the words where it is unknown."""
    for word in words:
        if np.isnan(y[word]):
            y[word] = 0.0


@dataclass(frozen=True, eq=False)
class Places:
    """Places of the listed words of every take that was used in learning."""

    words: Mapping[int, tuple[int, ...]]  # Capture number -> numbers of its listed words, rising
    # Capture number -> array (segments, listed words), y of the module's docstring
    shown: Mapping[int, FloatArray]
    # Capture number -> words of labels in other takes that its segments resemble, rising. Its own
    # captions do not list them. Only captures that have any
    inferred: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    # Capture number -> array (segments, inferred words), their y
    inferred_shown: Mapping[int, FloatArray] = field(default_factory=dict)

    def of(self, capture: int) -> Iterator[tuple[list[int], FloatArray]]:
        """Words of a take with their y (segments, words): the listed, and the inferred if any."""
        yield list(self.words[capture]), self.shown[capture]
        if capture in self.inferred:
            yield list(self.inferred[capture]), self.inferred_shown[capture]

    def only(self, captures: Container[int]) -> Places:
        """The places of some captures."""
        kept = [c for c in self.words if c in captures]
        inferred = [c for c in self.inferred if c in captures]
        return Places(
            {c: self.words[c] for c in kept},
            {c: self.shown[c] for c in kept},
            {c: self.inferred[c] for c in inferred},
            {c: self.inferred_shown[c] for c in inferred},
        )

    def listed_by(self, performers: Mapping[int, str]) -> dict[str, set[int]]:
        """Performer -> numbers of the words that captions of this performer's captures list."""
        listed: dict[str, set[int]] = {}
        for capture, words in self.words.items():
            listed.setdefault(performers[capture], set()).update(words)
        return listed


@dataclass(frozen=True, eq=False)
class Written:
    """The captions, and the learned words."""

    captions: Mapping[int, tuple[Caption, ...]]  # Capture number -> captions
    synonyms: Mapping[str, str]  # Lemma -> canonical lemma
    lemmas: Mapping[str, str]  # Lemmas that the dictionary gave
    numbers: Mapping[str, int]  # Word -> its number in the vocabulary

    def actions(self, caption: Caption) -> Actions:
        """Actions of a caption in the vocabulary; those without a known word are left out."""
        split = vocabulary.split_actions(caption.words, self.synonyms, self.lemmas)
        known = ([self.numbers[w] for w in action if w in self.numbers] for action in split)
        return [action for action in known if action]

    def of_whole(self, capture: int) -> list[Actions]:
        """Actions of every caption of the whole capture, those without any left out."""
        rows = [c for c in self.captions.get(capture, ()) if not is_interval(c)]
        return [actions for actions in map(self.actions, rows) if actions]

    def of_intervals(self, capture: int) -> list[tuple[Caption, Actions]]:
        """Captions of intervals with their actions, those without any left out."""
        rows = [c for c in self.captions.get(capture, ()) if is_interval(c)]
        return [(c, actions) for c, actions in zip(rows, map(self.actions, rows)) if actions]


@dataclass(frozen=True, eq=False)
class _Take:
    """One take's part of :class:`~motiondb.meaning.place_map.ListedTakes`."""

    actions: Actions
    further: list[int]
    labelled: FloatArray | None


def is_interval(caption: Caption) -> bool:
    """Whether a caption describes a part of its capture."""
    return caption.start is not None or caption.end is not None


def find_places(
    table: SegmentTable, standardised: Rows, written: Written, room: Room = np.empty
) -> Places | None:
    """Find where the actions of captions happen; None if no caption holds a known word.

    Shapes: `standardised` (segments, columns).

    `room`: Makes an array for the vectors of all windows, which is read and written at slices.
    """
    listed = listed_takes(table, standardised, written, room)
    if listed is None:
        return None
    captures, takes = listed
    with one_blas_thread():  # many small systems
        every = find_shown(takes, overwrite=True)
    words, shown = {}, {}
    inferred, inferred_shown = {}, {}
    for n, (capture, inside) in enumerate(zip(captures, takes.rows())):
        y = every[inside]
        said = _said_words(takes, n, inside)
        words[capture] = tuple(sorted(said))
        shown[capture] = y[:, list(words[capture])]
        others = set(np.flatnonzero((y > LEAST_INFERRED).any(axis=0)).tolist()) - said
        if others:
            inferred[capture] = tuple(sorted(others))
            inferred_shown[capture] = y[:, list(inferred[capture])]
    return Places(words, shown, inferred, inferred_shown)


def _said_words(takes: ListedTakes, n: int, rows: slice) -> set[int]:
    """The words of all captions of take n, and those that its labels say are not shown."""
    said = {word for action in takes.actions[n] for word in action} | set(takes.further[n])
    if takes.labelled is not None:
        labelled = ~np.isnan(takes.labelled[rows]).all(axis=0)
        said |= set(np.flatnonzero(labelled).tolist())
    return said


def listed_takes(
    table: SegmentTable, standardised: Rows, written: Written, room: Room = np.empty
) -> tuple[list[int], ListedTakes] | None:
    """Capture numbers and takes whose captions have known words; None if there are none."""
    rows = capture_rows(table)
    takes: dict[int, _Take] = {}
    for capture, inside in rows.items():
        take = _listed(table, inside, written, capture)
        if take is not None:
            takes[capture] = take
    if not takes:
        return None
    n_words = len(written.numbers)
    labelled = None
    if any(take.labelled is not None for take in takes.values()):
        labelled = np.concatenate(
            [
                np.full((rows[c].stop - rows[c].start, n_words), np.nan)
                if take.labelled is None
                else take.labelled
                for c, take in takes.items()
            ]
        )
    vectors, seconds, owners = _stacked(table, standardised, list(takes), room)
    actions = [take.actions for take in takes.values()]
    further = [take.further for take in takes.values()]
    return list(takes), ListedTakes(vectors, seconds, owners, actions, further, n_words, labelled)


@dataclass(frozen=True, eq=False)
class PlaceEvidence:
    """Evidence that words are shown at the segments of a capture, from the motion alone.

    For a take that was used in learning, the map is fitted without it.
    """

    places: Places
    performers: Mapping[int, str]  # Capture number -> performer
    table: SegmentTable
    standardised: Rows  # (segments, columns)
    rows: Mapping[int, slice]  # Capture number -> rows of the table
    placed: Mapping[int, slice]  # Capture number -> rows of ``fitted``, of takes that took part
    fitted: FittedPlaces | None  # None if no take of the table took part
    n_words: int
    kept: dict[int, TakeScores] = field(default_factory=dict, repr=False)
    maps: dict[frozenset[str], PlaceMap] = field(default_factory=dict, repr=False)
    # Performer -> placed capture -> evidence (segments, words) by the map of other performers
    of_performers: dict[str, dict[int, FloatArray]] = field(default_factory=dict, repr=False)

    @cached_property
    def words(self) -> frozenset[int]:
        """Numbers of the words whose places were learned."""
        return frozenset(word for words in self.places.words.values() for word in words)

    @cached_property
    def listed_by(self) -> dict[str, set[int]]:
        """Performer -> numbers of the words that were placed in this performer's captures."""
        return self.places.listed_by(self.performers)

    def take(self, capture: int) -> TakeScores | None:
        """The evidence for all words in a capture; None if there is none."""
        if self.fitted is None or capture not in self.rows:
            return None
        if capture not in self.kept:
            rows = self.rows[capture]
            with one_blas_thread():
                if capture in self.placed:
                    evidence = self.fitted.of_others(self.placed[capture])
                else:
                    vectors = window_vectors(self.table, self.standardised, [rows])
                    evidence = self.without(frozenset()).evidence(vectors)
            starts, ends = self.table.starts[rows], self.table.ends[rows]
            self.kept[capture] = TakeScores(starts, ends, evidence, evidence.max(axis=0))
        return self.kept[capture]

    def without(self, performers: frozenset[str]) -> PlaceMap:
        """The map without the takes of some performers; some take must have taken part."""
        assert self.fitted is not None
        if performers not in self.maps:
            with one_blas_thread():
                self.maps[performers] = self.fitted.without(self._placed_of(performers)[1])
        return self.maps[performers]

    def _placed_of(self, performers: frozenset[str]) -> tuple[list[int], IntArray]:
        """Captures of some performers that took part, and their rows of the regression."""
        captures = [capture for capture in self.placed if self.performers[capture] in performers]
        rows = (np.arange(self.placed[c].start, self.placed[c].stop) for c in captures)
        return captures, np.concatenate([np.zeros(0, dtype=np.int64), *rows])

    def by_others(self, capture: int) -> FloatArray | None:
        """Evidence (segments, words) for a capture by the map of other performers."""
        if self.fitted is None or capture not in self.rows:
            return None
        performer = self.performers[capture]
        if capture not in self.placed:
            vectors = window_vectors(self.table, self.standardised, [self.rows[capture]])
            return self.without(frozenset({performer})).evidence(vectors)
        if performer not in self.of_performers:
            captures, placed = self._placed_of(frozenset({performer}))
            with one_blas_thread():
                evidence = self.fitted.of_others(placed)
            ends = np.cumsum([self.placed[c].stop - self.placed[c].start for c in captures])
            self.of_performers[performer] = dict(zip(captures, np.split(evidence, ends[:-1])))
        return self.of_performers[performer][capture]

    def unplaced(self, said: Said, arrays: Mapping[str, FloatArray]) -> LeftOut | None:
        """Evidence for every word without its places, per take that was used in learning.

        Every segment of a take counts as showing all words of the take, each by 1 / sqrt(actions of
        the take). Arrays (segments, words), each by the map of all other takes, computed where they
        are looked at.

        `arrays`: Those that :func:`fit_arrays` gave for the same places, segments and words.
        """
        if self.fitted is None:
            return None
        captures, regression = list(self.placed), self.fitted.fitted.regression
        bounds = np.array([0, *(rows.stop for rows in self.placed.values())])

        def even_of(groups: Sequence[int]) -> FloatArray:
            rows = [np.zeros((bounds[n + 1] - bounds[n], self.n_words)) for n in groups]
            for n, even in zip(groups, rows):
                words, share = _even_share(said, captures[n])
                even[:, words] = share
            return np.concatenate(rows)

        mean, slopes = arrays["unplaced_mean"], arrays["unplaced_slopes"]
        centred = regression.centred(MadeRows(bounds, even_of), mean)
        return LeftOut(self.placed, FittedPlaces(Fitted(regression, mean, slopes, centred)))


@dataclass(frozen=True, eq=False)
class LeftOut(Mapping[int, FloatArray]):
    """Capture -> evidence (segments, words) by the map without it, computed where looked at."""

    placed: Mapping[int, slice]  # Capture number -> rows of ``fitted``
    fitted: FittedPlaces
    kept: dict[int, FloatArray] = field(default_factory=dict, repr=False)

    def __getitem__(self, capture: int) -> FloatArray:
        rows = self.placed[capture]
        if capture not in self.kept:
            with one_blas_thread():
                self.kept[capture] = self.fitted.of_others(rows)
        return self.kept[capture]

    def __iter__(self) -> Iterator[int]:
        return iter(self.placed)

    def __len__(self) -> int:
        return len(self.placed)


def _even_share(said: Said, capture: int) -> tuple[list[int], float]:
    """The words of a take, and the share of each at every segment."""
    words, n_actions = said.get(capture, (frozenset[int](), 1))
    return sorted(words), float(1.0 / np.sqrt(max(n_actions, 1)))


def fit_arrays(
    places: Places, table: SegmentTable, standardised: Rows, n_words: int, said: Said
) -> dict[str, FloatArray]:
    """What :func:`place_evidence` and :meth:`PlaceEvidence.unplaced` restore two regressions from.

    They differ in their targets alone. None of the arrays has a row for each segment. Without a
    take that took part there are none.
    """
    rows = capture_rows(table)
    captures = [capture for capture in rows if capture in places.words]
    if not captures:
        return {}
    n_columns = standardised.shape[1]
    total, vectors = 0.0, np.zeros(n_columns)
    gram = np.zeros((n_columns, n_columns))
    shown, even = (np.zeros((n_words, 1 + n_columns)) for _ in range(2))  # of 1 and of the columns
    ends = np.cumsum([rows[capture].stop - rows[capture].start for capture in captures])
    first = 0
    with one_blas_thread():  # sums of several threads differ in their last bits
        while first < len(captures):
            room = (ends[first - 1] if first else 0) + FITTED_AT_ONCE
            last = max(int(np.searchsorted(ends, room, side="right")), first + 1)
            some = {capture: rows[capture] for capture in captures[first:last]}
            roots = _roots(table, list(some.values()))
            x = window_vectors(table, standardised, list(some.values()))
            x *= roots
            gram += x.T @ x
            x *= roots
            weighted = np.concatenate([roots**2, x], axis=1)
            total += float(weighted[:, 0].sum())
            vectors += weighted[:, 1:].sum(axis=0)
            stops = np.cumsum([part.stop - part.start for part in some.values()]).tolist()
            for capture, a, b in zip(some, [0, *stops], stops):
                own = weighted[a:b]
                for words, y in places.of(capture):
                    shown[words] += y.T @ own
                words, share = _even_share(said, capture)
                even[words] += share * own.sum(axis=0)
            first = last
        centre = vectors / total
        gram += RIDGE * np.eye(n_columns) - total * np.outer(centre, centre)
        inverse = np.asarray(np.linalg.inv(gram), dtype=np.float64)
        arrays = {"centre": centre, "gram": gram, "inverse": inverse}
        for name, sums in (("", shown), ("unplaced_", even)):
            mean = sums[:, 0] / total
            cross = sums[:, 1:] - np.outer(sums[:, 0], centre)
            arrays |= {f"{name}mean": mean, f"{name}slopes": inverse @ cross.T}
    return arrays


def _roots(table: SegmentTable, parts: Sequence[slice]) -> FloatArray:
    """Roots of the weights of the segments of some takes: array (rows, 1)."""
    sizes = [part.stop - part.start for part in parts]
    owners = np.repeat(np.arange(len(parts), dtype=np.int64), sizes)
    lengths = table.ends - table.starts
    seconds = np.concatenate([lengths[part] for part in parts]) / MOTION_FPS
    return np.sqrt(take_weights(seconds, owners))[:, None]


def _restored(
    places: Places,
    table: SegmentTable,
    standardised: Rows,
    n_words: int,
    arrays: Mapping[str, FloatArray],
) -> tuple[dict[int, slice], FittedPlaces]:
    """Rows of the captures that took part, and the fitted regression, whose rows are made anew."""
    rows = capture_rows(table)
    captures = [capture for capture in rows if capture in places.words]
    sizes = [rows[capture].stop - rows[capture].start for capture in captures]
    bounds = np.cumsum([0, *sizes], dtype=np.int64)
    roots = _roots(table, [rows[capture] for capture in captures])

    def rows_of(groups: Sequence[int]) -> FloatArray:
        vectors = window_vectors(table, standardised, [rows[captures[n]] for n in groups])
        vectors -= arrays["centre"]
        vectors *= np.concatenate([roots[bounds[n] : bounds[n + 1]] for n in groups])
        return vectors

    def shown_of(groups: Sequence[int]) -> FloatArray:
        shown = [np.zeros((sizes[n], n_words)) for n in groups]
        for n, own in zip(groups, shown):
            for words, y in places.of(captures[n]):
                own[:, words] = y
        return np.concatenate(shown)

    fitted_to = (arrays[name] for name in ("centre", "gram", "inverse"))
    regression = Regression(MadeRows(bounds, rows_of), roots, *fitted_to)
    centred = regression.centred(MadeRows(bounds, shown_of), arrays["mean"])
    fitted = Fitted(regression, arrays["mean"], arrays["slopes"], centred)
    placed = {c: slice(int(a), int(b)) for c, a, b in zip(captures, bounds, bounds[1:])}
    return placed, FittedPlaces(fitted)


def place_evidence(
    places: Places,
    table: SegmentTable,
    standardised: Rows,
    n_words: int,
    performers: Mapping[int, str],
    arrays: Mapping[str, FloatArray],
) -> PlaceEvidence:
    """The evidence of places for the captures of a table; `standardised` (segments, columns).

    `arrays`: Those that :func:`fit_arrays` gave for the same places and segments.
    """
    rows = capture_rows(table)
    placed: dict[int, slice] = {}
    fitted = None
    if arrays:
        placed, fitted = _restored(places, table, standardised, n_words, arrays)
    return PlaceEvidence(places, performers, table, standardised, rows, placed, fitted, n_words)


def _stacked(
    table: SegmentTable, standardised: Rows, captures: Sequence[int], room: Room
) -> tuple[Float32Array, FloatArray, IntArray]:
    """Window vectors, seconds and take numbers of the segments of some captures."""
    rows = capture_rows(table)
    lengths = (table.ends - table.starts) / MOTION_FPS
    seconds = np.concatenate([lengths[rows[c]] for c in captures])
    sizes = [rows[c].stop - rows[c].start for c in captures]
    owners = np.repeat(np.arange(len(captures), dtype=np.int64), sizes)
    parts = [rows[c] for c in captures]
    return window_vectors(table, standardised, parts, np.float32, room), seconds, owners


def window_vectors(
    table: SegmentTable,
    standardised: Rows,
    parts: Sequence[slice],
    dtype: DTypeLike = np.float64,
    room: Room = np.empty,
) -> NDArray[Any]:
    """Vectors of the windows around the segments of captures: array (segments, columns).

    `parts`: The rows of each capture.
    """
    sizes = np.array([part.stop - part.start for part in parts], dtype=np.int64)
    ends = np.cumsum([0, *sizes])
    windows = room((int(ends[-1]), standardised.shape[1]), dtype)
    for some, vectors in window_vectors_of(standardised, table, parts, WINDOW_MARGIN):
        wholes = np.cumsum(sizes[some] + 1) - 1
        is_window = np.ones(wholes[-1] + 1, dtype=bool)
        is_window[wholes] = False
        windows[ends[some.start] : ends[some.stop]] = vectors[: len(is_window)][is_window]
    return windows


def _listed(table: SegmentTable, rows: slice, written: Written, capture: int) -> _Take | None:
    """The captions of one capture; None if they have no known words."""
    wholes, parts = written.of_whole(capture), written.of_intervals(capture)
    if not wholes and not parts:
        return None
    said = sorted({word for _, actions in parts for action in actions for word in action})
    labelled = label_intervals(table, rows, parts, not wholes, len(written.numbers))
    if not wholes:
        return _Take([said], [], labelled)
    order = max(wholes, key=len)
    listed = {word for action in order for word in action}
    others = {word for actions in wholes for action in actions for word in action}
    if labelled is not None:
        complete_labels(labelled, [set(action) for actions in wholes for action in actions])
    return _Take(order, sorted(others - listed), labelled)


def interval_evidence(
    table: SegmentTable, rows: Mapping[int, slice], written: Written
) -> dict[int, FloatArray]:
    """Nats for the place of words that captions of intervals say: arrays (segments, words).

    Only for the captures that have such captions.
    """
    evidence = {}
    for capture, inside in rows.items():
        parts = written.of_intervals(capture)
        said = label_intervals(table, inside, parts, False, len(written.numbers))
        if said is not None:
            evidence[capture] = LABELLED * np.nan_to_num(said)
    return evidence
