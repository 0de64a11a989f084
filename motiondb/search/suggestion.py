"""Which captures to caption next: active learning by expected reduction of variance.

Notation: v_u the score vector of capture u, of length 1. Whether captions of a motion have a word
is modelled by a Gaussian process over the vectors, with covariance and noise

    k(u, c) = exp(v_u . v_c - 1) = exp(-|v_u - v_c|^2 / 2),        noise r.

Given words of some captures, the uncertainty about u is its posterior variance C_uu, which does not
depend on the words. Words of c lower it by C_uc^2 / (r + C_cc). The next capture is

    argmax_c  sum_u w_u C_uc^2 / (r + C_cc),        then  C <- C - C_.c C_c. / (r + C_cc),

greedily, over the captures without words: a capture that resembles many others comes first, and a
capture that resembles an earlier choice gains little, so that the list is diverse.

Source: Cohn, Ghahramani, Jordan (1996), Seo et al. (2000): active learning by the expected
reduction of variance. Kernel and noise were chosen on CMU captures (``benchmarks/suggest.py``; the
page ``docs/suggest.md`` uses other splits). For performers without any words the order is no better
than chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray

NOISE = 0.1  # r, chosen by ``benchmarks/suggest.py``
SERVED = 0.25  # A choice serves a capture if it lowers its uncertainty by this share or more


@dataclass(frozen=True, eq=False)
class Suggestion:
    """One capture to caption."""

    index: int  # Row of the capture
    gain: float  # Share of the total initial uncertainty that its words remove, 0 to 1
    known: float  # Share of the capture's own uncertainty that was removed before
    # Other rows whose uncertainty its words lower by a quarter or more, most first
    served: IntArray


def suggest(
    vectors: FloatArray,
    described: FloatArray,
    limit: int,
    weights: FloatArray | None = None,
) -> list[Suggestion]:
    """Captures to caption, the one of largest gain first.

    Memory is 8 n^2 bytes for n captures without words.

    Shapes: `vectors` (n, symbols); `described` (m, symbols); `weights` (n,).

    >>> a, b = [1.0, 0.0], [0.0, 1.0]
    >>> chosen = suggest(np.array([b, a, b]), np.array([a]), 2)
    >>> [(s.index, s.served.tolist()) for s in chosen]
    [(0, [2]), (2, [0])]
    """
    weights = np.ones(len(vectors)) if weights is None else np.asarray(weights, dtype=np.float64)
    covariance = remaining_covariance(vectors, described)
    uncertain = float(weights @ np.diag(covariance))
    free = np.ones(len(vectors), dtype=bool)
    choices: list[Suggestion] = []
    while free.any() and len(choices) < limit:
        variance = np.diag(covariance).copy()
        gains = np.where(free, weights @ covariance**2 / (NOISE + variance), -1.0)
        best = int(np.argmax(gains))
        lowered = covariance[best] ** 2 / (NOISE + variance[best])
        share = lowered / variance
        others = np.flatnonzero((share >= SERVED) & (np.arange(len(variance)) != best))
        served = others[np.argsort(-share[others], kind="stable")]
        choices.append(
            Suggestion(best, float(gains[best]) / uncertain, 1.0 - float(variance[best]), served)
        )
        free[best] = False
        covariance -= np.outer(covariance[best], covariance[best]) / (NOISE + variance[best])
    return choices


def remaining_covariance(vectors: FloatArray, described: FloatArray) -> FloatArray:
    """Posterior covariance C given the described intervals: array (n, n).

    Shapes: `vectors` (n, symbols); `described` (m, symbols).
    """
    covariance = _kernel(vectors, vectors)
    if not len(described):
        return covariance
    cross = _kernel(described, vectors)
    known = _kernel(described, described) + NOISE * np.eye(len(described))
    half = np.linalg.solve(np.linalg.cholesky(known), cross)
    return covariance - half.T @ half


def _kernel(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.exp(np.clip(one @ other.T, -1.0, 1.0) - 1.0)
