"""Align the actions of a caption with the segments of a take, in the caption's order.

A caption of a long take lists its actions, mostly in the order in which they are performed, but
gives no times. Let r_ik be the log-likelihood ratio of action k against "none of the listed
actions" at segment i. The hidden sequence has one state for each action, and one *blank* before,
between and after the actions (ratio 0):

    blank_0, action_1, blank_1, action_2, ..., action_m, blank_m.

From one segment to the next the sequence stays in its state, moves to the next state, or moves from
an action to the next action without a blank. An action may be left out, at a cost of ``-SKIP``
nats. The forward and backward sums give the posterior probability of each action at each segment.

Source: Graves, Fernandez, Gomez and Schmidhuber (2006), Connectionist temporal classification.
Leaving actions out is added here, because captions list actions that are not performed.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray

SKIP = -10.0
"""Log-weight of leaving one listed action out, in nats. At -3 one action absorbs its neighbours: 6
of 13 questions about words of the takes' own captions were placed right. From -6 down to forbidding
it, 9 or 10 were. Leaving actions out must remain possible for takes with fewer segments than
actions."""


def align_in_order(log_ratios: FloatArray) -> FloatArray:
    """Return the posterior probability of each action at each segment.

    Parameters
    ----------
    log_ratios : array (segments, actions)
        Log-likelihood ratio of each action against none of them, in nats. The actions are in the
        order of the caption.

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
    """
    n_segments, n_actions = log_ratios.shape
    moves, first, last = _moves(n_actions)
    emitted = np.zeros((n_segments, 2 * n_actions + 1))
    emitted[:, 1::2] = log_ratios
    forward = np.empty_like(emitted)
    backward = np.empty_like(emitted)
    forward[0] = first + emitted[0]
    for i in range(1, n_segments):
        forward[i] = emitted[i] + _log_sum(forward[i - 1][:, None] + moves, axis=0)
    backward[-1] = last
    for i in range(n_segments - 2, -1, -1):
        backward[i] = _log_sum(moves + (emitted[i + 1] + backward[i + 1])[None, :], axis=1)
    joint = forward + backward
    joint -= _log_sum(joint, axis=1)[:, None]
    return np.exp(joint)[:, 1::2]


def _moves(n_actions: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the log-weights of moves (states, states), of first states and of last states."""
    n_states = 2 * n_actions + 1
    origin, target = np.meshgrid(np.arange(n_states), np.arange(n_states), indexing="ij")
    n_left_out = target // 2 - (origin + 1) // 2
    allowed = target >= origin
    moves = np.where(allowed, SKIP * np.maximum(n_left_out, 0), -np.inf)
    states = np.arange(n_states)
    first = SKIP * (states // 2).astype(float)
    last = SKIP * (n_actions - (states + 1) // 2).astype(float)
    return moves, first, last


def _log_sum(values: FloatArray, axis: int) -> FloatArray:
    """Return the logarithm of the sum of exponentials; one value along the axis must be finite."""
    top = values.max(axis=axis, keepdims=True)
    return np.asarray(np.log(np.exp(values - top).sum(axis=axis)) + top.squeeze(axis))
