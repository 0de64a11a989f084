"""What a learned association says of symbols and words that stand together, or symbols alone.

Notation as in :mod:`motiondb.words.association`. Where a shape (l, m) was never seen,
a(i | j, l, m) falls back to a diagonal: NULL with probability p0, position i >= 1 in proportion to
exp(-tension |(i - 1/2) / l - (j + 1/2) / m|), j from 0: people tell actions in the order in which
they happen. (Dyer, Chahuneau, Smith: fast_align, 2013, which also gives p0 and the tension.)

Expected counts are rounded to multiples of 2^-32. Sums of such numbers are exact in floating point
(up to two million captures), so adding a capture and removing it gives back the very same counts,
in whatever order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from motiondb.records import Association, FloatArray, IntArray

DIAGONAL_TENSION = 4.0
DIAGONAL_NULL = 0.08
_GRAIN = 2.0**32


@dataclass(frozen=True, eq=False)
class ExpectedCounts:
    """What captures say of t and a, under fixed old ones; additive over captures.

    Attributes
    ----------
    translation : array (symbols + 1, words); row 0 is NULL.
    alignment : (l, m) -> array (m, l + 1).
    n_pairs : how many captures are inside.
    """

    translation: FloatArray
    alignment: dict[tuple[int, int], FloatArray] = field(default_factory=dict)
    n_pairs: int = 0

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
    """a(i | j, l, m) as array (m, l + 1), rows sum to 1: the learned one, otherwise the diagonal.

    Parameters
    ----------
    n_symbols, n_words : l and m.
    tension : how strongly the fallback keeps the order; 0 makes it blind to order (Model 1).
    """
    learned = association.alignment.get((n_symbols, n_words))
    return diagonal_alignment(n_symbols, n_words, tension) if learned is None else learned


def diagonal_alignment(n_symbols: int, n_words: int, tension: float) -> FloatArray:
    """The fallback of the module's docstring, array (m, l + 1).

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
    """log P(words | symbols), nats; 0 where there are no words, -inf where one is impossible."""
    with np.errstate(divide="ignore"):
        return float(np.log(_joint(association, symbols, words).sum(axis=1)).sum())


def alignment_posterior(association: Association, symbols: IntArray, words: IntArray) -> FloatArray:
    """Which symbol each word comes from: array (m, l + 1), column 0 is NULL.

    Rows sum to 1; a row of a word that no symbol can say is 0.
    """
    joint = _joint(association, symbols, words)
    totals = joint.sum(axis=1, keepdims=True)
    return joint / np.where(totals > 0, totals, 1.0)


def pair_counts(association: Association, symbols: IntArray, words: IntArray) -> ExpectedCounts:
    """The expected counts of one capture, rounded to the grain of the module's docstring."""
    posterior = np.round(alignment_posterior(association, symbols, words) * _GRAIN) / _GRAIN
    translation = np.zeros_like(association.translation)
    sources = np.append(0, np.asarray(symbols) + 1)
    np.add.at(translation, (sources[None, :], np.asarray(words)[:, None]), posterior)
    if not len(words):
        return ExpectedCounts(translation, {}, 1)
    return ExpectedCounts(translation, {(len(symbols), len(words)): posterior}, 1)


def with_counts(association: Association, counts: ExpectedCounts) -> Association:
    """The association that counts amount to: the M-step. Rows without counts stay as they were.

    ``counts`` of the words and the trace of ``association`` are kept.
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
    """An association that trusts few examples less; what decoding should be given.

    EM drives t and a of rare symbols and of shapes seen once to 0 and 1. Here every row of t
    gives ``share`` to the words by how often they are written (NULL's row and rows of symbols
    never seen beside words included), and every alignment table is averaged with the diagonal,
    which counts as much as ``pseudo_pairs`` captures. Rows still sum to 1.

    Parameters
    ----------
    shapes : (l, m) -> number of captures that taught the table; 1 each where not given.
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


def word_presence(association: Association, symbols: IntArray) -> FloatArray:
    """P(word is said | symbols) = 1 - prod_i (1 - t(word | symbol_i)), array (words,)."""
    t = association.translation[np.asarray(symbols, dtype=np.int64) + 1]
    with np.errstate(divide="ignore"):
        return -np.expm1(np.log1p(-np.minimum(t, 1.0)).sum(axis=0))


def word_probabilities(association: Association, symbols: IntArray) -> FloatArray:
    """P(word | symbols) of a single word, all positions as likely, array (words,), sums to 1.

    Zero everywhere where no symbol was ever seen beside words.
    """
    t = association.translation[np.asarray(symbols, dtype=np.int64) + 1].sum(axis=0)
    return t / max(float(t.sum()), np.finfo(float).tiny)


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
