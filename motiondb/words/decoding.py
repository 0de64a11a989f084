"""From words to the motion symbols that most likely lie behind them, by A* with a certificate.

Looked for is the sequence s_1 .. s_l, of any length l up to a limit, that maximises

    log P(l | m) + log P(s_1 .. s_l) + sum_j log S_j,
    S_j = a(0 | j, l, m) t(word_j | NULL) + sum_i a(i | j, l, m) t(word_j | s_i),

with the bigram from begin to end (``words.transition``) and IBM Model 2 (``words.association``).
Each word's logarithm holds a sum over all positions, so the likelihood does not factor along the
sequence and a node of the search carries the sums S_j gathered so far.

The bound. log x <= log q + x / q - 1 for every q > 0. With any q_j > 0 the likelihood of every
completion is therefore at most sum_j (log q_j + S_j / q_j - 1), which *is* a sum over positions:
position i pays sum_j a(i | j, l, m) t(word_j | s_i) / q_j. Its maximum over completions,
transitions included, is found for all nodes at once by one backward dynamic program per length; it
never lies below the truth, so A* with it is optimal. That program also carries which words have
not been said yet, and holds a word never said to what is left for it; without this the bound is
too loose to be of use. See :mod:`motiondb.words.decoding_bounds`.

The search ends when no open node's bound exceeds the best sequence found: "optimal". Where it runs
into its limit of nodes first, the answer is "beam-limited", and ``bound`` says how much better a
sequence could be.

Source: Hart, Nilsson, Raphael (1968) for A*; Brown et al. (1993) for Model 2; paper A, eq. 7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import Association, FloatArray, IntArray
from motiondb.words.decoding_kernels import search_sequences
from motiondb.words.decoding_problem import pose_problem
from motiondb.words.explanation import DIAGONAL_TENSION, alignment_table

NODE_LIMIT = 5_000
"""Nodes that a search expands at most."""
OPEN_LIMIT = 100_000
"""Nodes that a search keeps at most."""


@dataclass(frozen=True)
class Decoding:
    """The answer to words, and how sure it is.

    Attributes
    ----------
    symbols : the sequence.
    log_probability : log P(l | m) + log P(symbols) + log P(words | symbols), nats.
    nodes_expanded : by A*.
    certificate : "optimal", or "beam-limited" where the search ran into its limit.
    bound : no sequence has a larger log-probability than this; equal to it where optimal.
    """

    symbols: tuple[int, ...]
    log_probability: float
    nodes_expanded: int
    certificate: str
    bound: float


def decode_words(
    words: Sequence[int] | IntArray,
    association: Association,
    log_transitions: FloatArray,
    log_lengths: FloatArray,
    *,
    tension: float = DIAGONAL_TENSION,
    node_limit: int = NODE_LIMIT,
) -> Decoding | None:
    """The motion symbols that most likely lie behind words.

    Parameters
    ----------
    words : word numbers (m,), at least one.
    association : t and a.
    log_transitions : array (symbols + 1, symbols + 1), from ``words.transition``.
    log_lengths : array (longest length + 1,), log P(l | m), see :func:`log_length_prior`.
    tension : of alignment tables that were never learned, see ``words.explanation``.
    node_limit : nodes to expand at most.

    Returns
    -------
    The answer, or None where every sequence has probability 0 or none was found within the limit.

    Raises
    ------
    ValueError : where there are no words, or the arrays do not fit one another.
    """
    numbers = np.asarray(words, dtype=np.int64)
    n_symbols = len(association.translation) - 1
    _check_shapes(numbers, n_symbols, log_transitions)
    longest = len(log_lengths) - 1
    alignments = np.zeros((longest + 1, len(numbers), longest + 1))
    for length in range(1, longest + 1):
        table = alignment_table(association, length, len(numbers), tension)
        alignments[length, :, : length + 1] = table
    problem = pose_problem(
        association.translation[:, numbers], alignments, log_transitions, log_lengths
    )
    symbols, value, bound, expanded = search_sequences(problem, node_limit, OPEN_LIMIT)
    if not np.isfinite(value):
        return None
    optimal = bound <= value
    return Decoding(
        symbols=tuple(int(s) for s in symbols),
        log_probability=float(value),
        nodes_expanded=int(expanded),
        certificate="optimal" if optimal else "beam-limited",
        bound=float(max(bound, value)),
    )


def log_length_prior(
    shapes: Mapping[tuple[int, int], float], n_words: int, longest: int | None = None
) -> FloatArray:
    """log P(l | m) of sequences up to a limit, learned from captures with words.

    A capture with m' words counts exp(-|m' - m|) times; one count is spread evenly over all
    lengths. Captures longer than the limit say nothing of lengths within it.

    Parameters
    ----------
    shapes : (l, m) -> number of captures.
    n_words : m.
    longest : the largest l, by default 2 m, at least 4.

    Returns
    -------
    array (longest + 1,); entry 0 is -inf, the others' exponentials sum to 1.

    >>> np.exp(log_length_prior({(1, 1): 3, (2, 1): 1}, 1, 2))
    array([0. , 0.7, 0.3])
    """
    longest = max(4, 2 * n_words) if longest is None else longest
    if longest < 1:
        raise ValueError(f"longest: expected a length of at least 1, found {longest}.")
    weights = np.append(0.0, np.full(longest, 1.0 / longest))
    for (length, width), count in shapes.items():
        if 1 <= length <= longest:
            weights[length] += count * np.exp(-abs(width - n_words))
    with np.errstate(divide="ignore"):
        return np.log(weights / weights.sum())


def _check_shapes(words: IntArray, n_symbols: int, log_transitions: FloatArray) -> None:
    if not len(words):
        raise ValueError("words: expected at least one word, found none.")
    if log_transitions.shape != (n_symbols + 1, n_symbols + 1):
        raise ValueError(
            f"log_transitions: expected shape {(n_symbols + 1, n_symbols + 1)} for "
            f"{n_symbols} symbols, found {log_transitions.shape}."
        )
