"""How sure answers are, learned by asking what is known already, with performers left out.

The captures that people wrote about are asked as a user would ask, each time with the words of the
performers in question left out of the word map (its sums are additive, so leaving out is taking
off), and whether an answer is right is read off what was written:

* by words: per fold of performers, every word that the others know is asked of the fold's captures;
* by example: an interval that was written about is the example, all other performers' captures are
  searched, each by its window that moves most alike; an answer is right where both were said to
  show the same action, which is a word that is no direction, part of the body or manner
  (``vocabulary.MODIFIERS``).

Only questions to which there is a right answer count here. From these
:mod:`motiondb.search.certainty` learns the probability of an answer. Then everything that would be
right is taken out, for an example from the word map too, and the same is asked again: that tells
how good the best answer is where there is nothing to find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.learning.counting import Described, capture_rows
from motiondb.records import FloatArray, IntArray, SegmentTable
from motiondb.search import by_motion, by_words, score_vectors
from motiondb.search.certainty import Certainty, clearest, fit_probability, separate, usual
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.words.vocabulary import MODIFIERS
from motiondb.words.word_map import WordMap, map_words
from motiondb.words.word_moments import WordMoments, solve_word_map, word_moments

N_FOLDS = 5
LEAST_SAID = 3
"""Intervals of other performers in which a word is said that is asked."""
LOOKED_AT, LOOKED_BELOW = 10, 5
"""Answers of a question that count: the best ones, and some evenly over the rest."""
MOST_EXAMPLES, MOST_CAPTURES = 40, 150
LEAST_ANSWERS = 30


@dataclass(frozen=True)
class Certainties:
    """How sure answers are; None where too little was written to tell.

    Attributes
    ----------
    words : Certainty or None
        Of an answer to words.
    example : Certainty or None
        Of an answer to an example.
    """

    words: Certainty | None = None
    example: Certainty | None = None


@dataclass(frozen=True, eq=False)
class Written:
    """Intervals that people wrote about, a row each, and the captures that they lie in.

    Attributes
    ----------
    vectors : array (rows, columns). presence : array (rows, words). names : of the words.
    captures, starts, ends, groups : arrays (rows,); frames; who performs.
    table : all segments. standardised : array (segments, columns).
    ridge, calibration : of the word map. margin : frames that a window reaches past its segment.
    n_bearing : how many of the last columns are posture and travel.
    """

    vectors: FloatArray
    presence: NDArray[np.bool_]
    names: Sequence[str]
    captures: IntArray
    starts: FloatArray
    ends: FloatArray
    groups: IntArray
    table: SegmentTable
    standardised: FloatArray
    ridge: float
    calibration: FloatArray
    margin: int = by_words.WINDOW_MARGIN
    n_bearing: int = 0

    @cached_property
    def moments(self) -> WordMoments:
        """Sums over all rows."""
        return word_moments(self.vectors, self.presence)

    @cached_property
    def segments(self) -> dict[int, slice]:
        """capture -> rows of the table."""
        return capture_rows(self.table)

    @cached_property
    def is_action(self) -> NDArray[np.bool_]:
        """Which words name an action: array (words,)."""
        return np.array([name not in MODIFIERS for name in self.names], dtype=bool)

    def without(self, rows: NDArray[np.bool_]) -> WordMap:
        """The word map that never saw some rows."""
        if np.count_nonzero(~rows) < self.vectors.shape[1]:  # the smaller system
            return map_words(
                self.vectors[~rows], self.presence[~rows], self.ridge, self.calibration
            )
        left = self.moments - word_moments(self.vectors[rows], self.presence[rows])
        return solve_word_map(left, self.ridge, self.calibration)


def intervals_of(described: Sequence[Described]) -> tuple[FloatArray, FloatArray]:
    """Starts and ends (frames) of the rows that ``counting.training_rows`` makes."""
    keys = list(dict.fromkeys((d.capture_id, d.start, d.end) for d in described))
    return np.array([k[1] for k in keys]), np.array([k[2] for k in keys])


def fit_certainties(written: Written) -> Certainties:
    """How sure answers are, where captions of two performers or more tell."""
    if len(np.unique(written.groups)) < 2:
        return Certainties()
    with one_blas_thread():  # many small systems
        return Certainties(words_certainty(written), example_certainty(written))


def words_certainty(written: Written) -> Certainty | None:
    """Of an action's log-odds in a capture; the threshold is of what the motion adds to what is
    usual, so that rare words can be found too."""
    log_odds, right, present, absent = [], [], [], []
    folds = _folds(written.groups)
    for fold in range(N_FOLDS):
        inside = folds == fold
        known = written.presence[~inside].sum(axis=0) >= LEAST_SAID
        if not known.any() or not inside.any():
            continue
        words = written.without(inside)
        captures = np.unique(written.captures[inside])
        heard = np.stack([_heard(written, words, int(c)) for c in captures])
        shown = np.stack([written.presence[written.captures == c].any(axis=0) for c in captures])
        usually = usual(words)
        for word in np.flatnonzero(known & shown.any(axis=0) & ~shown.all(axis=0)):
            best = _looked_at(heard[:, word])
            log_odds += heard[best, word].tolist()
            right += shown[best, word].tolist()
            added = heard[:, word] - usually[word]
            present.append(added.max())
            absent.append(added[~shown[:, word]].max())
    return _fit(np.array(log_odds)[:, None], right, present, absent)


def example_certainty(written: Written) -> Certainty | None:
    """Of the resemblance of an answer and of how clear the example's action is; the threshold is of
    the resemblance."""
    cues, right, present, absent = [], [], [], []
    share = _shared(written)
    elsewhere = share & (written.groups[:, None] != written.groups)
    able = np.flatnonzero(elsewhere.any(axis=1))
    chosen = able[np.linspace(0, len(able) - 1, min(len(able), MOST_EXAMPLES)).astype(int)]
    for row in np.unique(chosen) if len(able) else ():
        same = written.groups == written.groups[row]
        gallery = look_through(written, int(row), ~same, share[row])
        if not gallery.right.any():
            continue
        words = written.without(same)
        alike = gallery.alike(written, int(row), words)
        best = _looked_at(alike)
        clear = clearest(words, written.vectors[row], written.is_action)
        cues.append(np.column_stack([alike[best], np.full(len(best), clear)]))
        right += gallery.right[best].tolist()
        if not gallery.shows.all():
            nothing = gallery.alike(written, int(row), written.without(same | share[row]))
            present.append(float(alike.max()))
            absent.append(float(nothing[~gallery.shows].max()))
    return _fit(np.concatenate(cues), right, present, absent) if cues else None


@dataclass(frozen=True, eq=False)
class Gallery:
    """What is found in every capture when an example is asked, by motion alone.

    Attributes
    ----------
    vectors : array (captures, columns), of the window most like the example.
    right : array (captures,), whether that window was said to show the example's action.
    shows : array (captures,), whether any part of the capture was.
    """

    vectors: FloatArray
    right: NDArray[np.bool_]
    shows: NDArray[np.bool_]

    def alike(self, written: Written, row: int, words: WordMap) -> FloatArray:
        """Resemblance of every capture to the example: array (captures,)."""
        return by_motion.resemblance(
            written.vectors[row], self.vectors, words, n_bearing=written.n_bearing
        )


def look_through(
    written: Written, row: int, allowed: NDArray[np.bool_], said: NDArray[np.bool_]
) -> Gallery:
    """Ask an example of the captures that hold the rows allowed, or evenly chosen ones of many.

    allowed, said : arrays (rows,); which may be searched, which show the example's action.
    """
    captures = np.unique(written.captures[allowed])
    some = np.linspace(0, len(captures) - 1, min(len(captures), MOST_CAPTURES)).astype(int)
    length = max(round(float(written.ends[row] - written.starts[row])), 1)
    vectors, right, shows = [], [], []
    for capture in captures[some]:
        rows = written.segments[int(capture)]
        window, low, high = best_window(
            written.vectors[row], written.standardised[rows], written.table.starts[rows],
            written.table.ends[rows], length,
        )  # fmt: skip
        own = (written.captures == capture) & said
        meets = (written.starts < high) & (written.ends > low)
        vectors.append(window)
        right.append(bool((own & meets).any()))
        shows.append(bool(own.any()))
    return Gallery(np.array(vectors), np.array(right), np.array(shows))


def best_window(
    vector: FloatArray, standardised: FloatArray, starts: IntArray, ends: IntArray, length: int
) -> tuple[FloatArray, int, int]:
    """The window of a capture that moves most like a vector: its own vector, first and last + 1
    frame.

    standardised : array (segments, columns). starts, ends : arrays (segments,), frames.
    """
    low, high = by_motion.window_places(starts, ends, length)
    windows = score_vectors.interval_vectors(standardised, starts, ends, low, high)
    best = int(np.argmax(by_motion.resemblance(vector, windows)))
    return windows[best], int(low[best]), int(high[best])


def _fit(
    cues: FloatArray,
    right: Sequence[bool],
    present: Sequence[float],
    absent: Sequence[float],
) -> Certainty | None:
    """None where too few answers are known, all are right or wrong, or the first cue tells nothing
    of them."""
    truth = np.array(right, dtype=bool)
    if len(truth) < LEAST_ANSWERS or truth.all() or not truth.any():
        return None
    weights, constant = fit_probability(cues, truth)
    if weights[0] <= 0.0:
        return None
    return Certainty(weights, constant, separate(np.array(present), np.array(absent)))


def _folds(groups: IntArray) -> IntArray:
    """The fold of every row: groups whole, the largest dealt out first."""
    names, counts = np.unique(groups, return_counts=True)
    fold_of, sizes = {}, np.zeros(N_FOLDS)
    for g in np.lexsort([names, -counts]):
        fold_of[int(names[g])] = int(np.argmin(sizes))
        sizes[fold_of[int(names[g])]] += counts[g]
    return np.array([fold_of[int(g)] for g in groups])


def _heard(written: Written, words: WordMap, capture: int) -> FloatArray:
    """Log-odds of every word as the only action asked of a capture: array (words,)."""
    rows = written.segments[capture]
    odds = by_words.heard(
        words, written.standardised[rows], written.table.starts[rows], written.table.ends[rows],
        written.margin,
    )  # fmt: skip
    best: FloatArray = 0.5 * odds[:-1].max(axis=0) + 0.5 * odds[-1]
    return best


def _shared(written: Written) -> NDArray[np.bool_]:
    """Whether two rows were said to show the same action: array (rows, rows)."""
    actions = written.presence[:, written.is_action].astype(np.float32)
    shared: NDArray[np.bool_] = actions @ actions.T > 0
    return shared


def _looked_at(values: FloatArray) -> IntArray:
    """Which answers count, best first."""
    order = np.argsort(-values, kind="stable")
    best, rest = order[:LOOKED_AT], order[LOOKED_AT:]
    some = np.linspace(0, len(rest) - 1, min(LOOKED_BELOW, len(rest))).astype(int)
    return np.concatenate([best, rest[some]])
