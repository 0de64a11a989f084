"""Decoding of words to the most probable sequence of motion symbols, by A* with a certificate.

Decoding finds the sequence s_1 .. s_l, of any length l up to a limit, that maximises

    log P(l | m) + log P(s_1 .. s_l) + sum_j log S_j,
    S_j = a(0 | j, l, m) t(word_j | NULL) + sum_i a(i | j, l, m) t(word_j | s_i),

with the bigram from begin to end (:mod:`.transition`) and IBM Model 2 (:mod:`.association`).
The logarithm for each word is taken of a sum over all positions, so the likelihood does not factor
along the sequence; a node of the search carries the partial sums S_j.

The bound. log x <= log q + x / q - 1 for every q > 0. With any q_j > 0 the likelihood of every
completion is therefore at most sum_j (log q_j + S_j / q_j - 1), which *is* a sum over positions:
position i contributes sum_j a(i | j, l, m) t(word_j | s_i) / q_j. Its maximum over completions,
transitions included, is computed for all nodes at once by one backward dynamic program per length.
It is never below the true maximum, so that A* with it is optimal. The program also carries the set
of words that no symbol has accounted for yet, and bounds the probability of these words by the most
that the remaining symbols can give; without this the bound is too loose to be useful. See
:mod:`motiondb.language.translation.decoding_kernels`.

The search ends when the bound of no open node exceeds the best sequence found: the certificate is
"optimal". Where the limit of nodes is reached first it is "beam-limited", and ``bound`` is an upper
bound on the log-probability of every sequence.

Source: Hart, Nilsson, Raphael (1968) for A*; Brown et al. (1993) for Model 2; paper A, eq. 7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.translation.explanation import DIAGONAL_TENSION, alignment_table
from motiondb.records import Association, FloatArray, IntArray

NODE_LIMIT = 5_000
"""Largest number of nodes that a search expands. Chosen by hand: it bounds the time of a
question."""
OPEN_LIMIT = 100_000
"""Largest number of nodes that a search keeps. Chosen by hand: it bounds memory."""


@dataclass(frozen=True)
class Decoding:
    """The most probable sequence found, with a certificate."""

    symbols: tuple[int, ...]
    log_probability: float  # Log P(l | m) + log P(symbols) + log P(words | symbols), nats
    nodes_expanded: int  # Nodes that A* expanded
    certificate: str  # "optimal", or "beam-limited" where the search ran into its limit
    bound: float  # No sequence has a larger log-probability than this; equal to it where optimal


def decode_words(
    words: Sequence[int] | IntArray,
    association: Association,
    log_transitions: FloatArray,
    log_lengths: FloatArray,
    *,
    tension: float = DIAGONAL_TENSION,
    node_limit: int = NODE_LIMIT,
) -> Decoding | None:
    """Decode words to the most probable sequence of motion symbols.

    Shapes: `log_transitions` (symbols + 1, symbols + 1); `log_lengths` (longest length + 1,).
    """
    # compiled code, which most questions do without
    from motiondb.language.translation.decoding_kernels import pose_problem, search_sequences

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
    """log P(l | m) of sequences up to a limit, estimated from captures with words.

    A capture with m' words has the weight exp(-|m' - m|); one count is spread evenly over all
    lengths. Captures longer than the limit are left out.

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
