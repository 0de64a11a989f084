"""Fitting the judge of motion, and the calibration of its two cues.

The calibration uses real captures in pairs: one whose captions contain the word w, and one of the
same performer whose captions contain neither w nor a word related to it. In half of the pairs, the
second is one of the captures most similar to those of w. Both are judged without the two, each by
one or two of its windows, because generated motion is as short. The probability therefore assumes
prior odds of one to one.

A part of a capture of several actions may not show w. The first of a pair is therefore a capture
whose captions name one action, unless there are too few of these. No word has more than
``PAIRS_OF_A_WORD`` pairs, so that walking and running alone do not determine the probability.

On 505 pairs of CMU captures, 61 words, with the performers left out of the calibration: area under
the curve .84, expected calibration error .04; probabilities of .12, .29, .50, .70 and .94 were
right .21, .22, .47, .72 and .95 of the time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.calibration import Certainty, fit_probability
from motiondb.meaning.judging.motion_judge import (
    JudgingTable,
    MotionJudge,
    Said,
    judge_without,
    judging_table,
)
from motiondb.records import FloatArray
from motiondb.symbols.hmm_jobs import one_blas_thread

OTHERS = 3
"""Number of captures with which each capture is compared: more make the calibration more stable."""
PAIRS_OF_A_WORD = 30
"""Largest number of pairs of a word for the calibration. Chosen by hand: more take longer, and
words with many captures would outweigh the others."""
MOST_PAIRS = 3_000  # Largest number of pairs for the calibration. Chosen by hand: more take longer
PARTS = 2
"""Largest number of windows of a capture that are judged in the calibration: 3 to 4.5 s, about
the duration of an action in a generated motion."""
LEAST_PAIRS = 15  # Smallest number of pairs for a calibration, as for answers (``asked_certainty``)


def fit_judge(
    windows: Mapping[int, FloatArray],
    said: Said,
    n_words: int,
    performers: Mapping[int, str],
    rng: np.random.Generator,
) -> MotionJudge:
    """Fit the judge and its calibration."""
    rows = np.concatenate(list(windows.values()))
    captures = np.repeat(
        np.array(list(windows), dtype=np.int64), [len(w) for w in windows.values()]
    )
    spread = rows.std(axis=0)
    spread = np.maximum(spread, 1e-6 + 0.01 * spread.max())
    judge = MotionJudge(rows.mean(axis=0), spread, rows, captures, np.zeros(0))
    table = judging_table(judge, {c: said[c] for c in said if c in windows}, n_words)
    with one_blas_thread():  # many small systems
        pairs = _draw_pairs(table, performers, rng)
        if len(pairs) < LEAST_PAIRS:
            return judge
        cues, right = _compare(table, windows, pairs, rng)
    weights, constant = fit_probability(cues, right)
    packed = Certainty(weights, constant, float("nan")).pack()
    return MotionJudge(judge.mean, judge.spread, rows, captures, packed)


def _draw_pairs(
    table: JudgingTable, performers: Mapping[int, str], rng: np.random.Generator
) -> list[tuple[int, int, int]]:
    """Pairs of captures for the calibration: (word, capture with the word, capture without it).

    The first capture shows one action if there are enough of these; otherwise it may be any.
    """
    single = frozenset(c for c in table.said if table.said[c][1] <= 1)
    pairs = _pairs_of(table, performers, rng, single)
    if len(pairs) < LEAST_PAIRS:
        pairs = _pairs_of(table, performers, rng, frozenset(table.said))
    chosen = np.sort(rng.permutation(len(pairs))[:MOST_PAIRS])
    return [pairs[i] for i in chosen]


def _pairs_of(
    table: JudgingTable,
    performers: Mapping[int, str],
    rng: np.random.Generator,
    first: frozenset[int],
) -> list[tuple[int, int, int]]:
    """Pairs of which the first capture is one of ``first``."""
    evidence = table.vectors @ judge_all(table)
    scores = {c: evidence[table.owners == c].mean(axis=0) for c in table.said}
    pairs = []
    for word in np.flatnonzero(np.diag(table.together) >= 2.0).tolist():
        related = table.related(word)
        of_word: list[tuple[int, int, int]] = []
        for capture in sorted(c for c in first if word in table.said[c][0]):
            others = [
                c
                for c in sorted(table.said)
                if performers[c] == performers[capture] and not table.said[c][0] & related
            ]
            if not others:
                continue
            if rng.random() < 0.5:
                others.sort(key=lambda c: -scores[c][word])
                others = others[: max(3, len(others) // 3)]
            drawn = rng.permutation(len(others))[:OTHERS]
            of_word += [(word, capture, others[int(n)]) for n in drawn]
        kept = np.sort(rng.permutation(len(of_word))[:PAIRS_OF_A_WORD])
        pairs += [of_word[i] for i in kept]
    return pairs


def judge_all(table: JudgingTable) -> FloatArray:
    """Slopes of the regression on all windows: array (columns + 1, words)."""
    judged = judge_without(table, ())
    assert judged is not None  # a described capture has a window
    return judged.slopes


def _compare(
    table: JudgingTable,
    windows: Mapping[int, FloatArray],
    pairs: Sequence[tuple[int, int, int]],
    rng: np.random.Generator,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Cues of a part of each capture of every pair, and whether the capture has the word."""
    sums = table.sums()
    cues, right = [], []
    for word, says, says_not in pairs:
        left = judge_without(table, (says, says_not), sums)
        if left is None or left.n_captures[word] < 1.0:
            continue
        for capture, is_right in ((says, True), (says_not, False)):
            part = _part(windows[capture], rng)
            cues.append(left.cues(left.scores(part), word))
            right.append(is_right)
    return np.array(cues).reshape(-1, 2), np.array(right, dtype=bool)


def _part(rows: FloatArray, rng: np.random.Generator) -> FloatArray:
    """One to ``PARTS`` successive windows of a capture."""
    n_rows = min(int(rng.integers(1, PARTS + 1)), len(rows))
    start = int(rng.integers(len(rows) - n_rows + 1))
    return rows[start : start + n_rows]
