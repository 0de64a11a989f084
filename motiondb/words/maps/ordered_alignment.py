"""Align the actions of a caption with the segments of a take, in the caption's order.

A caption of a long take lists its actions, mostly in the order in which they are performed, but
gives no times. Let r_ik be the log-likelihood ratio of action k against "none of the listed
actions" at segment i. The hidden sequence has one state for each action, and one *blank* before,
between and after the actions (ratio 0):

    blank_0, action_1, blank_1, action_2, ..., action_m, blank_m.

From one segment to the next the sequence stays in its state, moves to the next state, or moves from
an action to the next action without a blank. An action may be left out, at a cost of ``-SKIP``
nats.

The segments of one action form a run of D seconds. Where durations are given, a run has the
log-weight

    -1/2 (ln(D / mu) / SPREAD)^2,    mu = (seconds of the take) / (number of actions):

a list of actions seldom means that one of them fills the take. Without it, an action with a little
evidence everywhere absorbs the segments of actions for which there is none yet. Forward and
backward sums over runs give the posterior probability of each action at each segment.

Source: Graves, Fernandez, Gomez and Schmidhuber (2006), Connectionist temporal classification; for
runs with durations, hidden semi-Markov models (Yu, 2010). Leaving actions out is added here,
because captions list actions that are not performed.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray

SKIP = -10.0
"""Log-weight of leaving one listed action out, in nats. At -3 one action absorbs its neighbours: 6
of 13 questions about words of the takes' own captions were placed right. From -6 down to forbidding
it, 9 or 10 were. Leaving actions out must remain possible for takes with fewer segments than
actions."""
SPREAD = 0.5
"""Standard deviation of the logarithm of a duration. On takes that were joined from Bandai-Namco
captures, with a fifth of the actions unlisted, .58 of 243 questions about listed actions were
placed right with 1, .65 with .5 and .35. On joined CMU captures it made no difference."""


def align_in_order(log_ratios: FloatArray, seconds: FloatArray | None = None) -> FloatArray:
    """Return the posterior probability of each action at each segment.

    Parameters
    ----------
    log_ratios : array (segments, actions)
        Log-likelihood ratio of each action against none of them, in nats. The actions are in the
        order of the caption.
    seconds : array (segments,), optional
        Duration of each segment, above 0. Without it all durations of runs have the same weight.

    Returns
    -------
    array (segments, actions)
        Probabilities. The rest to 1 in a row is the probability of the blanks.

    Examples
    --------
    The first and the last segment both look like the second action. The order decides.

    >>> ratios = np.array([[0.0, 5.0], [5.0, 0.0], [0.0, 5.0]])
    >>> align_in_order(ratios).round(2).tolist()
    [[0.5, 0.0], [0.99, 0.0], [0.0, 1.0]]

    Two segments look like either action. Durations divide them.

    >>> align_in_order(np.full((4, 2), 3.0), np.ones(4)).round(2).tolist()
    [[0.98, 0.0], [0.81, 0.18], [0.18, 0.81], [0.0, 0.98]]
    """
    n_segments, n_actions = log_ratios.shape
    weights = _run_weights(n_segments, n_actions, seconds)
    totals = np.concatenate([np.zeros((1, n_actions)), np.cumsum(log_ratios, axis=0)])

    def runs(k: int) -> FloatArray:
        return np.asarray(totals[None, :, k] - totals[:, None, k] + weights)

    forward = np.zeros((n_actions, n_segments + 1))
    for k in range(n_actions - 1):
        ended = np.logaddexp(_log_sum(forward[k][:, None] + runs(k), axis=0), forward[k] + SKIP)
        forward[k + 1] = np.logaddexp.accumulate(ended)
    posteriors = np.empty((n_segments, n_actions))
    backward = np.zeros(n_segments + 1)
    for k in range(n_actions - 1, -1, -1):
        ways = runs(k) + backward[None, :]
        begun = np.logaddexp(_log_sum(ways, axis=1), SKIP + backward)
        total = _log_sum(forward[k] + begun, axis=0)
        shares = np.exp(forward[k][:, None] + ways - total)
        covered = np.cumsum(shares.sum(axis=1) - shares.sum(axis=0))[:-1]
        posteriors[:, k] = np.clip(covered, 0.0, 1.0)
        backward = np.logaddexp.accumulate(begun[::-1])[::-1]
    return posteriors


def _run_weights(n_segments: int, n_actions: int, seconds: FloatArray | None) -> FloatArray:
    """Return the log-weights of the runs of segments [i, j): array (segments + 1, segments + 1)."""
    bounds = np.arange(n_segments + 1)
    weights = np.where(bounds[:, None] < bounds, 0.0, -np.inf)
    if seconds is None:
        return weights
    ends = np.concatenate([[0.0], np.cumsum(seconds)])
    shares = np.maximum(ends[None, :] - ends[:, None], 1e-9) * n_actions / ends[-1]
    return np.asarray(weights - 0.5 * (np.log(shares) / SPREAD) ** 2)


def _log_sum(values: FloatArray, axis: int) -> FloatArray:
    """Return the logarithm of the sum of exponentials; -inf where all values are."""
    top = np.maximum(values.max(axis=axis, keepdims=True), -1e300)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.exp(values - top).sum(axis=axis)) + top.squeeze(axis))
