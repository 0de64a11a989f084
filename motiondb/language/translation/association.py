"""Association of motion symbols with words: IBM Model 1, then Model 2.

Notation (Brown et al. 1993; paper A, eq. 4): the source is a sequence of l motion symbols with
NULL before it at position 0, the target a sequence of m words. Word j is explained by the symbol
at position i with probability a(i | j, l, m) t(word_j | symbol_i), so that

    P(words | symbols) = prod_j sum_i a(i | j, l, m) t(word_j | symbol_i).

Model 1 fixes a at 1 / (l + 1); Model 2 starts from its t and that a, and learns both by EM. The
paper writes a sum of likelihoods; here the sum of log-likelihoods is maximised, and no step lowers
it. Counts are normalised for every *position* of a word: a word that occurs twice in a caption is
explained twice (NLTK normalises per word type and counts it once).

Expected counts are additive over captures (:mod:`motiondb.language.translation.explanation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from motiondb.records import Association, FloatArray, IntArray

Pair = tuple[IntArray, IntArray]  # Numbers of the symbols (l,) and of the words (m,) of one capture


@dataclass(frozen=True, eq=False)
class PairTable:
    """All pairs, one after another, and the place of the alignment table of each."""

    sources: IntArray  # Positions of NULL and symbols: NULL is 0, symbol s is s + 1
    # (pairs + 1,): pair p has sources[source_starts[p]:source_starts[p + 1]]
    source_starts: IntArray
    words: IntArray  # Word numbers of all pairs
    word_starts: IntArray  # (pairs + 1,): pair p has words[word_starts[p]:word_starts[p + 1]]
    shapes: tuple[tuple[int, int], ...]  # The (l, m) that occur, sorted
    # (shapes,): start of the table of each shape in the flat array of alignment probabilities
    table_starts: IntArray
    n_cells: int  # Length of that array
    tables: IntArray  # (pairs,): start of the table of each pair
    row_sizes: IntArray  # (rows of all tables,): l + 1 for each row


def fit_association(
    pairs: Sequence[Pair],
    n_symbols: int,
    vocabulary: Sequence[str],
    *,
    model1_iterations: int = 10,
    model2_iterations: int = 20,
    tolerance: float = 1e-5,
) -> Association:
    """Learn t and a from captures with words.

    `pairs`: Symbols (l,) and word numbers (m,) of every described capture; empty ones are allowed.

    `tolerance`: The EM steps of a model end when the log-likelihood per word grows by less than
    this.

    >>> pairs = [(np.array([0]), np.array([0])), (np.array([0, 1]), np.array([0, 1]))]
    >>> fit_association(pairs, 2, ["walk", "sit"]).translation[2].round(2)
    array([0., 1.])
    """
    _check_pairs(pairs, n_symbols, len(vocabulary))
    table = lay_out(pairs)
    t, a = uniform_start(table, n_symbols, len(vocabulary))
    trace: list[float] = []
    for iterations, learn_a in ((model1_iterations, False), (model2_iterations, True)):
        t, a, rising = _run_em(table, t, a, iterations, tolerance, learn_a)
        trace.extend(rising)
    said = [word for _, words in pairs for word in set(words.tolist())]
    counts = np.bincount(np.array(said, dtype=np.int64), minlength=len(vocabulary))
    return Association(
        words=tuple(vocabulary),
        counts=counts,
        translation=np.ascontiguousarray(t.T),
        alignment=_tables_by_shape(table, a),
        log_likelihoods=np.array(trace),
    )


def lay_out(pairs: Sequence[Pair]) -> PairTable:
    """Put all pairs with words into arrays, one pair after another."""
    kept = [(symbols, words) for symbols, words in pairs if len(words)]
    each = [(len(symbols), len(words)) for symbols, words in kept]
    shapes = sorted(set(each))
    sizes = [(length + 1) * width for length, width in shapes]
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    number = dict(zip(shapes, starts.tolist()))
    lengths = np.array([length + 1 for length, _ in each], dtype=np.int64)
    source_starts = np.append(0, np.cumsum(lengths))
    sources = np.zeros(source_starts[-1], dtype=np.int64)
    behind_null = np.ones(len(sources), dtype=bool)
    behind_null[source_starts[:-1]] = False
    empty = np.zeros(0, dtype=np.int64)
    sources[behind_null] = np.concatenate([empty, *(s for s, _ in kept)]) + 1
    return PairTable(
        sources=sources,
        source_starts=source_starts,
        words=np.concatenate([empty, *(w for _, w in kept)]),
        word_starts=np.append(0, np.cumsum([width for _, width in each])).astype(np.int64),
        shapes=tuple(shapes),
        table_starts=starts[:-1],
        n_cells=int(starts[-1]),
        tables=np.array([number[shape] for shape in each], dtype=np.int64),
        row_sizes=np.array([n + 1 for n, width in shapes for _ in range(width)], dtype=np.int64),
    )


def uniform_start(table: PairTable, n_symbols: int, n_words: int) -> tuple[FloatArray, FloatArray]:
    """Start of Model 1: all words equally likely under every symbol, all positions equally likely.

    Shapes: result (words, symbols + 1).
    """
    t = np.zeros((n_words, n_symbols + 1))
    t[:, np.unique(table.sources)] = 1.0 / max(n_words, 1)
    return t, np.repeat(1.0 / table.row_sizes, table.row_sizes)


def em_step(
    table: PairTable, t: FloatArray, a: FloatArray, *, learn_a: bool
) -> tuple[FloatArray, FloatArray, float]:
    """One step of EM; `t` (words, symbols + 1); `a` (n_cells,)."""
    t_counts, a_counts = np.zeros_like(t), np.zeros_like(a)
    log_likelihood = expected_counts(
        table.sources,
        table.source_starts,
        table.words,
        table.word_starts,
        table.tables,
        t,
        a,
        t_counts,
        a_counts,
    )
    totals = t_counts.sum(axis=0)
    t = np.where(totals > 0, t_counts / np.where(totals > 0, totals, 1.0), t)
    return t, _normalise_tables(table, a_counts) if learn_a else a, log_likelihood


def _run_em(
    table: PairTable, t: FloatArray, a: FloatArray, iterations: int, tolerance: float, learn_a: bool
) -> tuple[FloatArray, FloatArray, list[float]]:
    """EM until it converges; the trace holds the log-likelihood after every step."""
    trace: list[float] = []
    before = None
    for _ in range(iterations):
        new_t, new_a, value = em_step(table, t, a, learn_a=learn_a)
        if before is not None:
            trace.append(value)
            if value - before <= tolerance * len(table.words):
                return t, a, trace
        t, a, before = new_t, new_a, value
    if iterations:
        trace.append(em_step(table, t, a, learn_a=False)[2])
    return t, a, trace


@njit(cache=True)
def expected_counts(  # noqa: PLR0913  numba compiles it with the table's arrays
    sources: IntArray,
    source_starts: IntArray,
    words: IntArray,
    word_starts: IntArray,
    tables: IntArray,
    t: FloatArray,
    a: FloatArray,
    t_counts: FloatArray,
    a_counts: FloatArray,
) -> float:
    """E step: add the expected counts of all pairs to ``t_counts`` and ``a_counts``.

    Axes as in :class:`PairTable` and :func:`em_step`. Returns the log-likelihood.
    """
    log_likelihood = 0.0
    longest = 0
    for p in range(len(tables)):
        longest = max(longest, source_starts[p + 1] - source_starts[p])
    joint = np.empty(longest)
    for p in range(len(tables)):
        first = source_starts[p]
        n = source_starts[p + 1] - first
        cell = tables[p]
        for j in range(word_starts[p], word_starts[p + 1]):
            t_row = t[words[j]]
            total = 0.0
            for i in range(n):
                joint[i] = t_row[sources[first + i]] * a[cell + i]
                total += joint[i]
            if total > 0.0:
                log_likelihood += np.log(total)
                count_row = t_counts[words[j]]
                for i in range(n):
                    share = joint[i] / total
                    count_row[sources[first + i]] += share
                    a_counts[cell + i] += share
            else:
                log_likelihood = -np.inf
            cell += n
    return log_likelihood


def _normalise_tables(table: PairTable, a_counts: FloatArray) -> FloatArray:
    if not len(a_counts):
        return a_counts
    row_starts = np.append(0, np.cumsum(table.row_sizes)[:-1])
    return a_counts / np.repeat(np.add.reduceat(a_counts, row_starts), table.row_sizes)


def _tables_by_shape(table: PairTable, a: FloatArray) -> dict[tuple[int, int], FloatArray]:
    return {
        (length, width): a[start : start + width * (length + 1)].reshape(width, length + 1).copy()
        for (length, width), start in zip(table.shapes, table.table_starts.tolist())
    }


def _check_pairs(pairs: Sequence[Pair], n_symbols: int, n_words: int) -> None:
    for what, side, limit in (("symbol", 0, n_symbols), ("word", 1, n_words)):
        for number, pair in enumerate(pairs):
            values = pair[side]
            if len(values) and not 0 <= values.min() <= values.max() < limit:
                bad = values[(values < 0) | (values >= limit)][0]
                raise ValueError(
                    f"pair {number}: expected {what} numbers from 0 to {limit - 1}, found {bad}. "
                    f"Number them as the {what}s were learned."
                )
