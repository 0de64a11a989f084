"""Copies among the captures of a database, looked for when captures are added.

The outlines of captures (:mod:`motiondb.search.copy_outlines`) are kept in the cache of the
database, so that the motions of captures that are there already need not be loaded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS, Float32Array, IntArray, Motion, Relation
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array, join_outlines, outline
from motiondb.workers import HERE, Workers

KIND = "outlines"  # Name of the outlines of all captures in the cache of the database


Made = tuple[Int16Array, float]
"""Outline (frames, 12) of a capture, and how far from it a copy may be."""


def load_outlines(
    opened: store.Store, ready: Mapping[int, Made] = MappingProxyType({})
) -> store.CaptureRows:
    """Outlines of all captures, and how far from them a copy may be.

    `ready`: Those that were made already, by number of the capture.
    """
    return store.cached_rows(opened, KIND, _make, ready)


def find_relations(
    opened: store.Store,
    new: set[str],
    known: store.CaptureRows,
    workers: Workers = HERE,
) -> tuple[list[Relation], dict[int, Made]]:
    """Copies, mirror images and cuts among the captures, of which at least one is new.

    Also gives the outlines that were made for it, by number of the capture.

    `new`: Names of captures.

    `known`: Outlines that were loaded before the new captures were saved.
    """
    infos, held = store.load_captures(opened), known.capture_ids.tolist()
    later = {info.capture_id for info in infos}.difference(held)
    # One after another: a merge may bring many hours
    made = {n: _make([motion])[0] for n, motion in store.readable_motions(opened, sorted(later))}
    place_of = {number: place for place, number in enumerate([*held, *made])}
    infos = [info for info in infos if info.capture_id in place_of]  # the sound ones
    numbers = [info.capture_id for info in infos]

    def poses_of(n: int) -> Float32Array:
        return copies.copy_poses(store.load_motion(opened, numbers[n]))

    new_rows = [rows for rows, _ in made.values()]
    sizes = np.array([*np.diff(known.bounds), *map(len, new_rows)], dtype=np.int64)
    reaches = np.array([*known.values, *(far for _, far in made.values())])
    places = np.array([place_of[number] for number in numbers], dtype=np.int64)
    firsts = (np.cumsum(sizes) - sizes)[places]
    new_limbs = join_outlines(new_rows).limbs
    limbs = _RowsOfBoth(known.rows if len(known.rows) else new_limbs[:0], new_limbs)
    library = copies.Library(sizes[places], reaches[places], firsts, limbs, poses_of)
    fresh = [n for n, info in enumerate(infos) if info.name in new]
    old = [n for n, info in enumerate(infos) if info.name not in new]
    found = copies.find_copies(library, fresh, None, workers)
    found += copies.find_copies(library, old, fresh, workers)
    relations = [
        Relation(
            infos[c.query].name,
            infos[c.take].name,
            c.kind,
            c.start / MOTION_FPS,
            c.end / MOTION_FPS,
            c.distance,
        )
        for c in found
    ]
    return relations, made


class _RowsOfBoth:
    """Rows that stand in the cache, and new ones behind them."""

    def __init__(self, held: Int16Array | store.CheckedRows, new: Int16Array) -> None:
        self._held, self._new = held, new

    def __getitem__(self, which: slice | IntArray) -> Int16Array:
        n_held = len(self._held)
        if isinstance(which, slice):
            if which.stop <= n_held:
                return self._held[which]
            new = self._new[max(which.start - n_held, 0) : which.stop - n_held]
            if which.start >= n_held:
                return new
            return np.concatenate([self._held[which.start : n_held], new])
        found = np.empty((*which.shape, N_AXES), dtype=np.int16)
        is_held = which < n_held
        found[is_held] = self._held[which[is_held]]
        found[~is_held] = self._new[which[~is_held] - n_held]
        return found


def _make(motions: Sequence[Motion]) -> list[Made]:
    """Outline and reach of some motions, in their order."""
    poses = (copies.copy_poses(motion) for motion in motions)
    return [(outline(each), copies.reach(each)) for each in poses]
