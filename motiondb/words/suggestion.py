"""Which captures to write words about next: those that leave the least uncertain about the rest.

Notation: v_u the score vector of capture u (length 1). How likely a word is said of a motion is
taken as a Gaussian process over the vectors, with covariance and noise

    k(u, c) = exp(v_u . v_c - 1) = exp(-|v_u - v_c|^2 / 2),        noise r (words are not exact).

With words about some captures, what remains uncertain of u is its posterior variance C_uu; it does
not depend on what the words say. Words about c lower it by C_uc^2 / (r + C_cc). So the choice is

    argmax_c  sum_u w_u C_uc^2 / (r + C_cc),        then  C <- C - C_.c C_c. / (r + C_cc),

greedily, over the captures without words: a capture that stands for many others comes first, and
what is like an earlier choice gains little, so that the list is diverse.

Source: Cohn, Ghahramani, Jordan (1996), Seo et al. (2000): active learning by the expected
reduction of variance. Kernel and noise were chosen on real captures (``benchmarks/suggest.py``).
Words of performers who have none at all are not found sooner than by chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray

NOISE = 0.1
SERVED = 0.25
"""Words serve a capture whose uncertainty they lower by this share."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """One choice.

    Attributes
    ----------
    index : the chosen row. gain : what its words take off the uncertainty, as a share of all that
        there was at the beginning, 0 to 1. known : share of its own that was off before.
    served : array, other rows of whose uncertainty its words take off a quarter or more, most
        first.
    """

    index: int
    gain: float
    known: float
    served: IntArray


def suggest(
    vectors: FloatArray,
    described: FloatArray,
    limit: int,
    weights: FloatArray | None = None,
) -> list[Suggestion]:
    """The captures to write words about, the most telling first.

    Needs 8 n^2 bytes for n captures without words.

    Parameters
    ----------
    vectors : array (n, symbols), score vectors of the captures without words, of length 1.
    described : array (m, symbols), vectors of the intervals that have words; m may be 0.
    limit : how many at most.
    weights : array (n,), how much each capture counts; 1 each by default.

    >>> a, b = [1.0, 0.0], [0.0, 1.0]
    >>> found = suggest(np.array([b, a, b]), np.array([a]), 2)
    >>> [(s.index, s.served.tolist()) for s in found]
    [(0, [2]), (2, [0])]
    """
    weights = np.ones(len(vectors)) if weights is None else np.asarray(weights, dtype=np.float64)
    covariance = remaining_covariance(vectors, described)
    uncertain = float(weights @ np.diag(covariance))
    free = np.ones(len(vectors), dtype=bool)
    found: list[Suggestion] = []
    while free.any() and len(found) < limit:
        own = np.diag(covariance).copy()
        gains = np.where(free, weights @ covariance**2 / (NOISE + own), -1.0)
        best = int(np.argmax(gains))
        lowered = covariance[best] ** 2 / (NOISE + own[best])
        share = lowered / own
        others = np.flatnonzero((share >= SERVED) & (np.arange(len(own)) != best))
        served = others[np.argsort(-share[others], kind="stable")]
        found.append(
            Suggestion(best, float(gains[best]) / uncertain, 1.0 - float(own[best]), served)
        )
        free[best] = False
        covariance -= np.outer(covariance[best], covariance[best]) / (NOISE + own[best])
    return found


def remaining_covariance(vectors: FloatArray, described: FloatArray) -> FloatArray:
    """C of the module's docstring, given the described intervals: array (n, n)."""
    covariance = _kernel(vectors, vectors)
    if not len(described):
        return covariance
    cross = _kernel(described, vectors)
    known = _kernel(described, described) + NOISE * np.eye(len(described))
    half = np.linalg.solve(np.linalg.cholesky(known), cross)
    return covariance - half.T @ half


def _kernel(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.exp(np.clip(one @ other.T, -1.0, 1.0) - 1.0)
