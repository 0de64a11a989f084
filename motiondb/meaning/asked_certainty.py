"""Certainty of answers, learned from questions whose answers are known from the captions.

**One action, or an example.** The captures with captions are searched as a user would search, each
time without the words of the tested performers in the word map. Only questions to which there is a
right answer count:

* by words: performers are divided into folds; every word of the other folds is searched in the
  captures of one fold;
* by example: a described interval is the example; the captures of all other performers are
  searched, each by its window that moves most like the example. An answer is right if both captions
  name the same action, that is, a word that is not a direction, a part of the body or a manner
  (``vocabulary.MODIFIERS``).

Then all right answers are removed (for an example, also from the word map) and the search is
repeated: this gives the value of the best answer if there is no right one.

**"a but not b" and "a or b".** The log-odds of an action and of an excluded one are not
independent: with the probability of single words multiplied, "a but not b" got .41 in the mean
where .67 of the answers were right. Instead, such questions are made from the captions, if the
captures of a fold of performers distinguish them:

    a but not b    some captures show a with b, and some a without b,
    a or b         some captures show a without b, and some b without a,

and searched in these captures with the word map without these performers. For each kind two
probabilities are learned from the same cues: that all of the question holds, and that the action
that the answer shows does (a; for "or" the alternative that the capture shows best). Cues: for "a
but not b" the log-odds of a and those of b with reversed sign; for "a or b" the log-odds of the
alternative that is shown best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.language.question.readings import Exclusion, Part, Reading
from motiondb.language.vocabulary import MODIFIERS
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.meaning import by_question, score_vectors
from motiondb.meaning.caption_map import CaptionMap, solve_caption_map
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.regression import (
    Certainties,
    Certainty,
    KindCertainty,
    fit_probability,
    kind_cues,
    separate,
)
from motiondb.meaning.resemblance import emphasis_of, resemblance
from motiondb.meaning.score_vectors import Rows
from motiondb.meaning.windows import window_places
from motiondb.meaning.word_evidence import (
    TakeExtremes,
    TakeScores,
    hear_takes,
    take_extremes,
    upper_bounds,
)
from motiondb.meaning.word_map import (
    WordMap,
    WordMoments,
    clearest,
    map_words,
    solve_word_map,
    usual,
    word_moments,
)
from motiondb.records import FloatArray, IntArray, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread

N_FOLDS = 5  # Folds of performers
LEAST_SAID = 3
"""Smallest number of intervals of other performers with a word, for the word to be used as a
question."""
LOOKED_AT, LOOKED_BELOW = 10, 5
"""Answers of a question that are used: the best ones, which a user sees, and some at even distances
in the rest."""
MOST_EXAMPLES, MOST_CAPTURES = 40, 150  # Bounds on the duration of this step of learning
LEAST_ANSWERS = 30  # Smallest number of answers for which a probability is fitted


@dataclass(frozen=True, eq=False)
class Written:
    """Described intervals, one row each, and their captures."""

    vectors: FloatArray  # (rows, columns): score vectors
    presence: NDArray[np.bool_]  # (rows, words): which words were written about each interval
    names: Sequence[str]
    captures: IntArray  # (rows,): capture numbers
    starts: FloatArray  # (rows,): first frames, 30 a second
    ends: FloatArray  # (rows,): last frames + 1
    groups: IntArray  # (rows,): number of the performer
    table: SegmentTable
    standardised: Rows  # (segments, columns): standardised scores and movement
    ridge: float  # Ridge of the word map
    calibration: FloatArray  # (3,): calibration of the word map
    n_posture_and_travel: int = 0  # Number of the last columns that are posture and travel
    # Where words are learned from more than these rows (``motiondb.learn.joining``): fits the word
    # map without some rows (array (rows,), bool), and adds the other sums to sums over these rows
    fit_without: Callable[[NDArray[np.bool_]], WordMap] | None = None
    join: Callable[[WordMoments], WordMoments] | None = None

    @cached_property
    def moments(self) -> WordMoments:
        """Sums over all rows."""
        return word_moments(self.vectors, self.presence)

    @cached_property
    def segments(self) -> dict[int, slice]:
        """Capture number -> rows of the table."""
        return capture_rows(self.table)

    @cached_property
    def is_action(self) -> NDArray[np.bool_]:
        """Which words name an action: array (words,)."""
        return np.array([name not in MODIFIERS for name in self.names], dtype=bool)

    @cached_property
    def meanings(self) -> FloatArray:
        """Vectors of the words: array (words, axes)."""
        return word_vectors().of(self.names)

    @cached_property
    def folds(self) -> list[HeardFold]:
        """The captures of every fold of performers, heard without the fold."""
        numbers = performer_folds(self.groups)
        heard = []
        for fold in np.unique(numbers):
            known = self.presence[numbers != fold].sum(axis=0) >= LEAST_SAID
            if known.any():
                heard.append(_hear_fold(self, numbers == fold, known))
        return heard

    def captions_without(self, rows: NDArray[np.bool_]) -> CaptionMap:
        """The caption map fitted without some rows."""
        left = self.moments - word_moments(self.vectors[rows], self.presence[rows])
        return solve_caption_map(left if self.join is None else self.join(left), self.meanings)

    def without(self, rows: NDArray[np.bool_]) -> WordMap:
        """The word map fitted without some rows."""
        if self.fit_without is not None:
            return self.fit_without(rows)
        if np.count_nonzero(~rows) < self.vectors.shape[1]:  # the smaller system
            return map_words(
                self.vectors[~rows], self.presence[~rows], self.ridge, self.calibration
            )
        left = self.moments - word_moments(self.vectors[rows], self.presence[rows])
        return solve_word_map(left, self.ridge, self.calibration)


@dataclass(frozen=True, eq=False)
class HeardFold:
    """The captures of some performers, heard by maps that were fitted without them."""

    known: NDArray[np.bool_]  # (words,): words that enough captions of others hold
    takes: list[TakeScores]  # Log-odds of all words in every capture, from its motion
    shown: NDArray[np.bool_]  # (captures, words): which words the captures' captions hold
    usual: FloatArray  # (words,): log-odds without evidence from motion


def _hear_fold(written: Written, inside: NDArray[np.bool_], known: NDArray[np.bool_]) -> HeardFold:
    """Hear the captures of the rows ``inside`` by maps without these rows."""
    words, captures = written.without(inside), np.unique(written.captures[inside])
    rows = {int(capture): written.segments[int(capture)] for capture in captures}
    captions, table = written.captions_without(inside), written.table
    odds = hear_takes(words, captions, written.standardised, table, rows).by_capture(rows)
    return HeardFold(
        known,
        [
            TakeScores(table.starts[part], table.ends[part], odds[c][:-1], odds[c][-1])
            for c, part in rows.items()
        ],
        np.stack([written.presence[written.captures == c].any(axis=0) for c in captures]),
        usual(words),
    )


def words_certainty(written: Written) -> Certainty | None:
    """Certainty of an answer to words; its cue is the log-odds of an action in a capture.

    The threshold is on the log-odds that the motion adds to the usual ones, so that rare words can
    be found too. None if too little was written.
    """
    log_odds, right, present, absent = [], [], [], []
    for fold in written.folds:
        shown = fold.shown
        every = np.stack([0.5 * take.windows.max(axis=0) + 0.5 * take.whole for take in fold.takes])
        for word in np.flatnonzero(fold.known & shown.any(axis=0) & ~shown.all(axis=0)):
            odds = every[:, word]  # of the word as the only action
            best = _counting_answers(odds)
            log_odds += odds[best].tolist()
            right += shown[best, word].tolist()
            added = odds - fold.usual[word]
            present.append(added.max())
            absent.append(added[~shown[:, word]].max())
    return _if_helpful(_fit(np.array(log_odds)[:, None], right, present, absent))


def example_certainty(written: Written) -> Certainty | None:
    """Certainty of an answer to an example.

    Its cues are the resemblance of the answer and how clear the example's action is; the threshold
    is on the resemblance. None if too little was written.
    """
    cues, right, present, absent = [], [], [], []
    actions = written.presence[:, written.is_action]
    said = [actions[written.groups == group].any(axis=0) for group in np.unique(written.groups)]
    elsewhere = np.sum(said, axis=0) > 1  # actions that captions of two performers name
    able = np.flatnonzero((actions & elsewhere).any(axis=1))
    chosen = able[np.linspace(0, len(able) - 1, min(len(able), MOST_EXAMPLES)).astype(int)]
    of_others: dict[int, WordMap] = {}  # by performer
    for row in np.unique(chosen) if len(able) else ():
        performer = int(written.groups[row])
        same = written.groups == performer
        share = (actions & actions[row]).any(axis=1)  # rows that show an action of this one
        gallery = find_windows(written, int(row), ~same, share)
        if not gallery.right.any():
            continue
        words = of_others.get(performer) or written.without(same)
        of_others[performer] = words
        alike = gallery.alike(written, int(row), words)
        best = _counting_answers(alike)
        clear = clearest(words, written.vectors[row], written.is_action)
        cues.append(np.column_stack([alike[best], np.full(len(best), clear)]))
        right += gallery.right[best].tolist()
        if not gallery.shows.all():
            nothing = gallery.alike(written, int(row), written.without(same | share))
            present.append(float(alike.max()))
            absent.append(float(nothing[~gallery.shows].max()))
    return _if_helpful(_fit(np.concatenate(cues), right, present, absent)) if cues else None


@dataclass(frozen=True, eq=False)
class Gallery:
    """The best window of every capture for an example, by motion alone."""

    vectors: FloatArray  # (captures, columns): score vector of the window most like the example
    # (captures,): whether this window shows the example's action, according to captions
    right: NDArray[np.bool_]
    # (captures,): whether any part of the capture does, according to captions
    shows: NDArray[np.bool_]

    def alike(self, written: Written, row: int, words: WordMap) -> FloatArray:
        """Resemblance of every capture to the example: array (captures,)."""
        return resemblance(
            written.vectors[row],
            self.vectors,
            words,
            n_posture_and_travel=written.n_posture_and_travel,
            emphasis=emphasis_of(written.names),
        )


def find_windows(
    written: Written, row: int, allowed: NDArray[np.bool_], said: NDArray[np.bool_]
) -> Gallery:
    """Compare an example with the captures of the allowed rows; of many, with evenly chosen ones.

    Shapes: `allowed`, `said` (rows,).
    """
    captures = np.unique(written.captures[allowed])
    some = np.linspace(0, len(captures) - 1, min(len(captures), MOST_CAPTURES)).astype(int)
    length = max(round(float(written.ends[row] - written.starts[row])), 1)
    vectors, right, shows = [], [], []
    for capture in captures[some]:
        rows = written.segments[int(capture)]
        window, low, high = best_window(
            written.vectors[row],
            written.standardised[rows],
            written.table.starts[rows],
            written.table.ends[rows],
            length,
        )
        showing = (written.captures == capture) & said
        meets = (written.starts < high) & (written.ends > low)
        vectors.append(window)
        right.append(bool((showing & meets).any()))
        shows.append(bool(showing.any()))
    return Gallery(np.array(vectors), np.array(right), np.array(shows))


def best_window(
    vector: FloatArray, standardised: FloatArray, starts: IntArray, ends: IntArray, length: int
) -> tuple[FloatArray, int, int]:
    """The window of a capture that moves most like a vector.

    Shapes: `vector` (columns,); `standardised` (segments, columns); `starts`, `ends` (segments,).
    """
    low, high = window_places(starts, ends, length)
    windows = score_vectors.interval_vectors(standardised, starts, ends, low, high)
    best = int(np.argmax(resemblance(vector, windows)))
    return windows[best], int(low[best]), int(high[best])


def _fit(
    cues: FloatArray,
    right: Sequence[bool],
    present: Sequence[float] = (),
    absent: Sequence[float] = (),
) -> Certainty | None:
    """Fit probability and threshold; None if too few answers are known, or all right or wrong."""
    truth = np.array(right, dtype=bool)
    if len(truth) < LEAST_ANSWERS or truth.all() or not truth.any():
        return None
    weights, constant = fit_probability(cues, truth)
    return Certainty(weights, constant, separate(np.array(present), np.array(absent)))


def _if_helpful(sure: Certainty | None) -> Certainty | None:
    """A certainty whose first cue, by which answers are ranked, raises the probability."""
    return sure if sure is not None and sure.weights[0] > 0.0 else None


def performer_folds(groups: IntArray) -> IntArray:
    """Fold of every row; no group is divided, and the largest is assigned first."""
    names, counts = np.unique(groups, return_counts=True)
    fold_of, sizes = {}, np.zeros(N_FOLDS)
    for g in np.lexsort([names, -counts]):
        fold_of[int(names[g])] = int(np.argmin(sizes))
        sizes[fold_of[int(names[g])]] += counts[g]
    return np.array([fold_of[int(g)] for g in groups])


def _counting_answers(values: FloatArray) -> IntArray:
    """Numbers of the answers that are used, best first."""
    order = np.argsort(-values, kind="stable")
    best, rest = order[:LOOKED_AT], order[LOOKED_AT:]
    some = np.linspace(0, len(rest) - 1, min(LOOKED_BELOW, len(rest))).astype(int)
    return np.concatenate([best, rest[some]])


LEAST_EACH = 2  # Smallest number of captures on each side of the distinction of a question
FIRST = 5  # Answers of a question that are used: those that a user reads first
MOST_QUESTIONS = 100
"""Largest number of questions of a kind and a fold, a bound on the duration of learning."""


@dataclass(frozen=True, eq=False)
class MadeQuestion:
    """A question made from captions."""

    readings: tuple[Reading, ...]
    right: NDArray[np.bool_]  # (captures,): which captures show all of it
    # (readings, captures): which captures show the action that each reading asks for
    shown: NDArray[np.bool_]


@dataclass(frozen=True)
class _Answers:
    """Cues of answers, and whether all of the question and the part are right."""

    cues: list[FloatArray] = field(default_factory=list)
    whole: list[bool] = field(default_factory=list)
    part: list[bool] = field(default_factory=list)

    def fit(self) -> KindCertainty:
        cues = np.array(self.cues)
        return KindCertainty(_fit(cues, self.whole), _fit(cues, self.part))


def without_and_either(written: Written) -> tuple[KindCertainty, KindCertainty]:
    """Certainties of answers to "a but not b" and to "a or b"."""
    without, either = _Answers(), _Answers()
    for fold in written.folds:
        verbs = np.flatnonzero(fold.known & written.is_action)
        some = _evenly(len(fold.takes), MOST_CAPTURES)
        takes, shown = [fold.takes[n] for n in some], fold.shown[some]
        extremes = take_extremes(dict(enumerate(takes)))
        for answers, questions in (
            (without, list(without_questions(shown, verbs, written.names))),
            (either, list(either_questions(shown, verbs, written.names))),
        ):
            for n in _evenly(len(questions), MOST_QUESTIONS):
                _ask(answers, takes, extremes, questions[n], written.names)
    return without.fit(), either.fit()


def without_questions(
    shown: NDArray[np.bool_], verbs: IntArray, names: Sequence[str]
) -> Iterator[MadeQuestion]:
    """Questions "a but not b" that some captures distinguish.

    Shapes: `shown` (captures, words); `verbs` (verbs,).
    """
    for a in verbs:
        for b in verbs:
            both, alone = shown[:, a] & shown[:, b], shown[:, a] & ~shown[:, b]
            if a != b and min(both.sum(), alone.sum()) >= LEAST_EACH:
                excluded = Exclusion(((names[b],),), 0, 1)
                reading = Reading((Part(((names[a],),)),), (excluded,))
                yield MadeQuestion((reading,), alone, shown[:, [a]].T)


def either_questions(
    shown: NDArray[np.bool_], verbs: IntArray, names: Sequence[str]
) -> Iterator[MadeQuestion]:
    """Questions "a or b" that some captures distinguish; parameters as `without_questions`."""
    for n, a in enumerate(verbs):
        for b in verbs[n + 1 :]:
            only_a, only_b = shown[:, a] & ~shown[:, b], shown[:, b] & ~shown[:, a]
            either = shown[:, a] | shown[:, b]
            if min(only_a.sum(), only_b.sum()) >= LEAST_EACH and not either.all():
                read = tuple(Reading((Part(((names[w],),)),)) for w in (a, b))
                yield MadeQuestion(read, either, shown[:, [a, b]].T)


def _ask(
    answers: _Answers,
    takes: Sequence[TakeScores],
    extremes: TakeExtremes,
    question: MadeQuestion,
    names: Sequence[str],
) -> None:
    """Search the captures for one question, and record its first answers."""
    number = {name: n for n, name in enumerate(names)}
    ranked = by_question.likeliest_takes(
        extremes.captures,
        upper_bounds(extremes, question.readings, number),
        lambda n: by_question.search_take(takes[n], question.readings, number),
        FIRST,
    )
    for n, hit in ranked:
        asked, excluded = by_question.split_statements(hit.statements)
        answers.cues.append(kind_cues(asked[0], excluded[0] if excluded else None))
        answers.whole.append(bool(question.right[n]))
        answers.part.append(bool(question.shown[hit.reading, n]))


def _evenly(n: int, most: int) -> IntArray:
    """At most ``most`` of the numbers 0 to n - 1, at even distances."""
    return np.unique(np.linspace(0, max(n - 1, 0), min(n, most)).astype(np.int64))


def fit_certainties(written: Written) -> Certainties:
    """Certainties of answers, if there are captions of two or more performers."""
    if len(np.unique(written.groups)) < 2:
        return Certainties()
    with one_blas_thread():  # many small systems
        without, either = without_and_either(written)
        return Certainties(
            words_certainty(written),
            example_certainty(written),
            without=without,
            either=either,
        )
