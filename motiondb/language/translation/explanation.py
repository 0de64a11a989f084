"""Probabilities of words given symbols, and of alignments, under a learned association.

Notation as in :mod:`motiondb.language.translation.association`. Where a shape (l, m) was never
seen,
a(i | j, l, m) is replaced by a diagonal: NULL with probability p0, position i >= 1 in proportion to
exp(-tension |(i - 1/2) / l - (j + 1/2) / m|), j from 0, because captions name actions in their
order.

Expected counts are rounded to multiples of 2^-32. Sums of such numbers are exact in floating point
for up to two million captures, so that adding a capture and removing it again, in any order,
restores exactly the same counts.

Source: Dyer, Chahuneau, Smith, A simple, fast, and effective reparameterization of IBM Model 2,
2013, for the diagonal with its p0 and tension.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from motiondb.records import LARGEST, Association, Axes, FloatArray, IntArray, Within

DIAGONAL_TENSION = 4.0  # Value of the source
DIAGONAL_NULL = 0.08  # p0, value of the source
_GRAIN = 2.0**32  # counts are multiples of its reciprocal, see the module


@dataclass(frozen=True, eq=False)
class ExpectedCounts:
    """Expected counts of t and a under fixed parameters; additive over captures."""

    # Row 0 is NULL
    translation: Annotated[
        FloatArray,
        Axes("symbols + 1", "words"),
        Within(0.0, LARGEST, "expected counts of at least 0"),
    ]
    # (l, m) -> array (m, l + 1)
    alignment: dict[tuple[int, int], FloatArray] = field(default_factory=dict)
    n_pairs: Annotated[int, Within(1, LARGEST, "at least one described interval")] = 0

    def __add__(self, other: ExpectedCounts) -> ExpectedCounts:
        return _combine(self, other, 1)

    def __sub__(self, other: ExpectedCounts) -> ExpectedCounts:
        return _combine(self, other, -1)


def alignment_table(
    association: Association,
    n_symbols: int,
    n_words: int,
    tension: float = DIAGONAL_TENSION,
) -> FloatArray:
    """a(i | j, l, m) as array (m, l + 1), rows sum to 1: learned, or else the diagonal.

    `tension`: Strength with which the diagonal prefers the order of the words; 0 ignores order
    (Model 1).
    """
    learned = association.alignment.get((n_symbols, n_words))
    return diagonal_alignment(n_symbols, n_words, tension) if learned is None else learned


def diagonal_alignment(n_symbols: int, n_words: int, tension: float) -> FloatArray:
    """Alignment probabilities of the diagonal (see the module), array (m, l + 1).

    >>> diagonal_alignment(2, 1, 4.0).round(2)
    array([[0.08, 0.46, 0.46]])
    """
    if n_symbols == 0:
        return np.ones((n_words, 1))
    i = (np.arange(n_symbols) + 0.5) / n_symbols
    j = (np.arange(n_words) + 0.5) / max(n_words, 1)
    near = np.exp(-tension * np.abs(i[None, :] - j[:, None]))
    near *= (1.0 - DIAGONAL_NULL) / near.sum(axis=1, keepdims=True)
    return np.hstack([np.full((n_words, 1), DIAGONAL_NULL), near])


def log_probability(association: Association, symbols: IntArray, words: IntArray) -> float:
    """log P(words | symbols), nats; 0 if there are no words, -inf where one is impossible."""
    with np.errstate(divide="ignore"):
        return float(np.log(_joint(association, symbols, words).sum(axis=1)).sum())


def alignment_posterior(association: Association, symbols: IntArray, words: IntArray) -> FloatArray:
    """Posterior probability of the symbol behind each word: array (m, l + 1), column 0 is NULL.

    Rows sum to 1; the row of a word that has probability 0 under every symbol is 0.
    """
    joint = _joint(association, symbols, words)
    totals = joint.sum(axis=1, keepdims=True)
    return joint / np.where(totals > 0, totals, 1.0)


def pair_counts(association: Association, symbols: IntArray, words: IntArray) -> ExpectedCounts:
    """Expected counts of one capture, rounded to multiples of 2^-32."""
    posterior = np.round(alignment_posterior(association, symbols, words) * _GRAIN) / _GRAIN
    translation = np.zeros_like(association.translation)
    sources = np.append(0, np.asarray(symbols) + 1)
    np.add.at(translation, (sources[None, :], np.asarray(words)[:, None]), posterior)
    if not len(words):
        return ExpectedCounts(translation, {}, 1)
    return ExpectedCounts(translation, {(len(symbols), len(words)): posterior}, 1)


def with_counts(association: Association, counts: ExpectedCounts) -> Association:
    """M step: the association with t and a of expected counts; rows without counts are kept.

    The word counts and the trace of ``association`` are kept too.
    """
    totals = counts.translation.sum(axis=1, keepdims=True)
    translation = np.where(
        totals > 0, counts.translation / np.where(totals > 0, totals, 1.0), association.translation
    )
    alignment = {}
    for shape, table in counts.alignment.items():
        sums = table.sum(axis=1, keepdims=True)
        uniform = 1.0 / table.shape[1]
        alignment[shape] = np.where(sums > 0, table / np.where(sums > 0, sums, 1.0), uniform)
    return Association(
        association.words, association.counts, translation, alignment, association.log_likelihoods
    )


def smoothed(
    association: Association,
    shapes: Mapping[tuple[int, int], float] | None = None,
    *,
    share: float = 0.05,
    pseudo_pairs: float = 5.0,
) -> Association:
    """Smooth an association for decoding.

    EM drives t and a of rare symbols and of shapes seen once to 0 and 1. Here every row of t is
    mixed, with weight ``share``, with the relative frequency of the words (also NULL's row), and
    rows of symbols never seen with words become that frequency. Every alignment table is averaged
    with the diagonal, whose weight is that of ``pseudo_pairs`` captures. Rows still sum to 1. Both
    defaults were chosen by hand.

    `shapes`: Number of captures from which each alignment table was learned; 1 where not given.
    """
    written = (association.counts + 0.5) / (association.counts + 0.5).sum()
    t = association.translation
    t = np.where(t.sum(axis=1, keepdims=True) > 0, (1.0 - share) * t + share * written, written)
    alignment = {}
    for shape, table in association.alignment.items():
        trust = (shapes or {}).get(shape, 1) / ((shapes or {}).get(shape, 1) + pseudo_pairs)
        diagonal = diagonal_alignment(*shape, DIAGONAL_TENSION)
        alignment[shape] = trust * table + (1.0 - trust) * diagonal
    return Association(
        association.words, association.counts, t, alignment, association.log_likelihoods
    )


def _joint(association: Association, symbols: IntArray, words: IntArray) -> FloatArray:
    """a(i | j, l, m) t(word_j | symbol_i), array (m, l + 1)."""
    sources = np.append(0, np.asarray(symbols, dtype=np.int64) + 1)
    numbers = np.asarray(words, dtype=np.int64)
    t = association.translation[sources[None, :], numbers[:, None]]
    return t * alignment_table(association, len(symbols), len(numbers))


def _combine(one: ExpectedCounts, other: ExpectedCounts, sign: int) -> ExpectedCounts:
    alignment = dict(one.alignment)
    for shape, table in other.alignment.items():
        alignment[shape] = alignment.get(shape, np.zeros_like(table)) + sign * table
        if not alignment[shape].any():
            del alignment[shape]
    return ExpectedCounts(
        one.translation + sign * other.translation, alignment, one.n_pairs + sign * other.n_pairs
    )
