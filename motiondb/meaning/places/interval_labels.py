"""Where captions of intervals say that words are shown, and what else follows from them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.records import MOTION_FPS, Caption, FloatArray, SegmentTable

Actions = list[list[int]]  # Word numbers of every action, in order


def label_intervals(
    table: SegmentTable,
    rows: slice,
    parts: Sequence[tuple[Caption, Actions]],
    nowhere_else: bool,
    n_words: int,
) -> FloatArray | None:
    """y (segments, words) that captions of intervals give; None without any."""
    if not parts:
        return None
    starts, ends = table.starts[rows], table.ends[rows]
    labelled = np.full((len(starts), n_words), np.nan)
    words = sorted({word for _, actions in parts for action in actions for word in action})
    if nowhere_else:
        labelled[:, words] = 0.0
    for caption, actions in parts:
        low = (caption.start or 0.0) * MOTION_FPS
        high = float(ends[-1]) if caption.end is None else caption.end * MOTION_FPS
        shared = np.minimum(ends, high) - np.maximum(starts, low)
        inside = 2.0 * shared >= ends - starts
        if not inside.any():  # shorter than half of every segment that it meets
            inside = shared == shared.max()
        for word in {word for action in actions for word in action}:
            labelled[inside, word] = 1.0
    return labelled


def complete_labels(labelled: FloatArray, listed: Sequence[set[int]]) -> None:
    """Set y to 0, in place, where labels imply that a word is not shown.

    A labelled interval lasts from the begin to the end of its action, so that the segments before
    and after it do not show it; nor does it show other actions that captions of the take list. A
    listed action with a word more or less than the label ("side twist", "twist") may be the same.
    The segments before and after may show other listed actions that share words with the label.

    Shapes: `labelled` (segments, words).
    """
    labels = [set(np.flatnonzero(row == 1.0).tolist()) for row in labelled]
    for row, label in enumerate(labels):
        if not label:
            continue
        same = [action for action in listed if action <= label or action >= label]
        others = set().union(*(action for action in listed if action not in same))
        _set_unknown(labelled[row], set().union(*listed).difference(*same))
        for beside in (row - 1, row + 1):
            if 0 <= beside < len(labels):
                _set_unknown(labelled[beside], label - others - labels[beside])


def _set_unknown(y: FloatArray, words: set[int]) -> None:
    """Set y to 0, in place, for those of the words where it is unknown."""
    for word in words:
        if np.isnan(y[word]):
            y[word] = 0.0
