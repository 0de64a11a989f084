"""One open database: the store, and the only cache of loaded data.

Everything that is kept belongs to one revision of the store, which every committed change raises
(:func:`motiondb.store.revision`). Cached values are used as long as the revision is the same, and
need not be removed by hand. Threads may share a session.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache, partial
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from motiondb import store
from motiondb.body.features import N_FEATURES, features_of_motions
from motiondb.errors import NotLearnedError
from motiondb.language.nearby.table import NearbyTable, read_table
from motiondb.learn.checking import given_certainties
from motiondb.learn.learned import Learned, prepare, with_prepared
from motiondb.learn.learned_model import from_stored
from motiondb.learn.recognition import FeaturePool, recognise_capture
from motiondb.meaning.counting import join_tables
from motiondb.records import Float32Array, Motion
from motiondb.workers import HERE, Workers, runs

T = TypeVar("T")
TABLE = "words.table"  # The shipped table of nearby words
FEATURE_SECONDS = 1e-5  # Time of one processor for a frame; decides only how work is divided
FEATURES = "features"  # Name of the features of all captures in the cache of the database


class Session:
    """The store of one open database, and the values kept for its present revision."""

    def __init__(
        self, path: str | Path, *, read_only: bool = False, create: bool = True, wait: float = 0.0
    ) -> None:
        self.store = store.open_store(path, read_only=read_only, create=create, wait=wait)
        self._lock = threading.RLock()
        self._revision = -1
        self._kept: dict[Hashable, Any] = {}
        self._loading: dict[Hashable, threading.RLock] = {}

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self.store.close()

    @contextmanager
    def reading(self) -> Iterator[None]:
        """One state of the database for the whole block, even if others save changes."""
        with store.reading(self.store):
            yield

    def kept(self, key: Hashable, load: Callable[[], T]) -> T:
        """A value for the revision that is being read: kept, or loaded now.

        `load`: Loads it; called in a ``reading`` block. It may ask for other values, but not for
        those that are loaded with this one. Other threads that ask for the same value wait for it.
        Nothing is kept where it raises, within a transaction, or while a block reads an earlier
        revision than the newest one read.
        """
        with store.reading(self.store) as revision:
            if self.store.in_transaction:  # it may yet be undone
                return load()
            with self._lock:
                if revision > self._revision:
                    self._revision, self._kept, self._loading = revision, {}, {}
                is_newest = revision == self._revision
                if is_newest and key in self._kept:
                    return cast(T, self._kept[key])
                loading = self._loading.setdefault(key, threading.RLock())
            if not is_newest:
                return load()
            with loading:  # of this value only: a long load keeps nobody from other values
                return self._loaded(key, revision, load)

    def _loaded(self, key: Hashable, revision: int, load: Callable[[], T]) -> T:
        """The value that another thread has loaded meanwhile, or a new one, which is kept."""
        with self._lock:
            if revision == self._revision and key in self._kept:
                return cast(T, self._kept[key])
        value = load()
        with self._lock:
            if revision == self._revision:
                self._kept[key] = value
        return value

    @property
    def learned(self) -> Learned:
        """The learned model, with the catalogue of the same revision."""
        return self.kept("learned", lambda: _prepared(self.store, load_learned(self.store)))

    @property
    def searchable(self) -> Learned:
        """The learned model, with the generated captures in addition to those learned from.

        ``learn`` passes over generated captures, so that the database does not learn from itself.
        They take no part in counts, nor as material for further generation. Search finds them: here
        they are cut and scored by the learned symbols.
        """
        return self.kept("searchable", lambda: _searchable(self.store, self.learned))

    @property
    def features(self) -> FeaturePool:
        """Recognition features of all captures."""
        return self.kept("features", lambda: load_features(self.store))

    def lacking_features(self) -> dict[int, Motion]:
        """Motions of the captures whose features are not in the cache of the database."""
        with self.reading():
            return store.lacking_rows(self.store, FEATURES)

    def keep_features(self, made: Mapping[int, FeaturesMade]) -> None:
        """Keep features that were computed while the file was free.

        `made`: Features of captures by number; those that were removed meanwhile are left out.
        """
        with self.reading():
            self.kept("features", lambda: load_features(self.store, made))


def load_learned(opened: store.Store) -> Learned:
    """Load the data that questions need, all of one revision."""
    with store.reading(opened):
        if not store.is_learned(opened):
            raise NotLearnedError(
                f"{opened.path}: expected a database that has learned, found only captures. "
                "Run motiondb learn first."
            )
        model = from_stored(store.load_learning(opened))
        return Learned(
            **{**vars(model), "certainties": given_certainties(model.certainties, model.counted)},
            captures={info.capture_id: info for info in store.load_captures(opened)},
            captions=store.load_captions(opened),
            synonyms=store.load_synonyms(opened),
            source=str(opened.path),
        )


FeaturesMade = tuple[NDArray[Any], float]
"""Features (frames, 130) of a capture, and the length of its motion in frames."""


def load_features(
    opened: store.Store,
    ready: Mapping[int, FeaturesMade] = MappingProxyType({}),
    workers: Workers = HERE,
) -> FeaturePool:
    """Features of all motions; computed once, then memory-mapped from the cache of the database.

    `ready`: Features that were computed already, by number of the capture.
    """
    held = store.cached_rows(opened, FEATURES, partial(_made_by, workers), ready)
    none = np.zeros((0, N_FEATURES), dtype=np.float32)
    features = cast(Float32Array, held.rows) if len(held.rows) else none
    return FeaturePool(held.capture_ids, held.bounds, features, held.values.astype(np.int64))


def make_features(motions: Sequence[Motion]) -> list[FeaturesMade]:
    """Features and length of some motions, in their order."""
    parts = features_of_motions(motions)
    return [(part, float(motion.n_frames)) for part, motion in zip(parts, motions)]


def _made_by(workers: Workers, motions: Sequence[Motion]) -> list[FeaturesMade]:
    """As :func:`make_features`, by workers."""
    pieces = runs(motions, workers.n_pieces(FEATURE_SECONDS * sum(m.n_frames for m in motions)))
    return [made for part in workers.map(make_features, pieces) for made in part]


def _with_generated(opened: store.Store, learned: Learned) -> Learned:
    """The learned model, with segments of the generated captures if there are any."""
    generated = sorted(i.capture_id for i in learned.captures.values() if i.kind == "generated")
    if not generated:
        return learned
    tables = [recognise_capture(learned, c, store.load_motion(opened, c)) for c in generated]
    return replace(learned, segments=join_tables(learned.segments, *tables))


def _searchable(opened: store.Store, learned: Learned) -> Learned:
    """The learned model with the generated captures, and what questions need of all captures."""
    every = _with_generated(opened, learned)
    return learned if every is learned else _prepared(opened, every, "searched")


def _prepared(opened: store.Store, learned: Learned, kind: str = "evidence") -> Learned:
    """The learned model with arrays of all captures from the cache of the database."""
    mark = store.learning_mark(opened)
    return with_prepared(learned, store.cached_arrays(opened, kind, lambda: prepare(learned), mark))


@lru_cache(maxsize=1)
def nearby_table() -> NearbyTable:
    """The table that is shipped with motiondb; read once."""
    file = resources.files("motiondb.language.nearby").joinpath(TABLE)
    return read_table(file.read_bytes(), TABLE)
