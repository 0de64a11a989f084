"""At which frames actions begin and end: learned at ``learn`` from the places of words.

See :mod:`motiondb.meaning.maps.edge_map`. Frames take the y of their segment.
"""

from __future__ import annotations

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.learn.symbol_fitting import FeaturePool
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.maps.edge_map import EdgeMap, FrameTake, fit_edge_map
from motiondb.meaning.places.place_fitting import Places
from motiondb.records import Float32Array, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread


def fit_edges(
    frames: Float32Array, pool: FeaturePool, table: SegmentTable, places: Places, n_words: int
) -> EdgeMap:
    """Fit the evidence for words at each frame; `frames` (rows, D)."""
    rows = capture_rows(table)
    bounds = zip(pool.capture_ids.tolist(), pool.bounds[:-1], pool.bounds[1:])
    takes = []
    for capture, first, last in bounds:
        if capture not in places.words:
            continue
        middles = FEATURE_STEP * (np.arange(last - first) + 0.5)
        ends = table.ends[rows[capture]]
        segments = np.minimum(np.searchsorted(ends, middles, side="right"), len(ends) - 1)
        shown = places.shown[capture][segments]
        takes.append(FrameTake(frames[first:last], places.words[capture], shown))
    with one_blas_thread():  # sums of several threads differ in their last bits
        return fit_edge_map(takes, n_words)
