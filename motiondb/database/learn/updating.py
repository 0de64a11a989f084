"""Keeping what was learned true while captures and words change, without learning anew.

One context manager surrounds every change of captures, words or synonyms: before it, the counts of
the captures that will change are taken off; after it, those that are there are counted (captures
that are new are first cut and scored by the stored symbols), and everything that follows from the
counts is published in the same transaction. Counts are exact (see :mod:`counting`), so that a
capture that was added and removed leaves no trace.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from motiondb import store
from motiondb.database.learn import counting
from motiondb.database.learn.learning import FeaturePool, recut_settings, segment_table
from motiondb.pose.features import recognition_features
from motiondb.records import Caption, FloatArray, Learning, MotionSymbols, SegmentTable
from motiondb.symbols import acquisition, feature_space
from motiondb.words import vocabulary


@dataclass
class Change:
    """What a change brings; the body of :func:`counted` fills ``added``.

    Attributes
    ----------
    added : numbers of captures that the body adds.
    counted : numbers of captures that were counted in the end.
    new_words : words outside the vocabulary in their captions, to be counted at the next learn.
    """

    added: list[int] = field(default_factory=list)
    counted: tuple[int, ...] = ()
    new_words: tuple[str, ...] = ()


@contextmanager
def changing(
    database: store.Store, kind: str, parameters: Mapping[str, object], touched: Iterable[int] = ()
) -> Iterator[Change]:
    """A transaction with a run of its own around :func:`counted`."""
    with store.transaction(database):
        run_id = store.start_run(database, kind, parameters)
        with counted(database, run_id, touched) as change:
            yield change
        store.finish_run(database, run_id)


@contextmanager
def counted(database: store.Store, run_id: int, touched: Iterable[int] = ()) -> Iterator[Change]:
    """Surround a change of captures or words, inside a transaction, so that counts stay true.

    Parameters
    ----------
    run_id : of the change; the rows that are published name it.
    touched : numbers of captures whose words may change, or that may be removed.

    Where the database has not learned (or learned before counts were kept), nothing is counted.
    """
    change, wanted = Change(), set(touched)
    if not can_count(database):
        yield change
        return
    learning = store.load_learning(database)
    counts, reference = counting.unpack(
        learning.parameters, learning.association, learning.transition_counts
    )
    table = learning.segments
    wanted &= set(table.capture_ids.tolist())
    counts = counts - _count(database, _only(table, wanted), reference)
    yield change
    there = {i.capture_id for i in store.load_captures(database) if i.kind == "captured"}
    table = _only(table, there)
    new = sorted(set(change.added) & there)
    if not new and not wanted:
        return
    if new:
        own = recognise_captures(database, learning.symbols, learning.parameters, new)
        table = _join(table, own)
    again = _only(table, wanted | set(new))
    counts = counts + _count(database, again, reference)
    change.counted = tuple(counting.capture_rows(again))
    change.new_words = unknown_words(database, change.counted, reference.association.words)
    store.save_learning(database, _publish(learning, run_id, table, counts, reference))


def can_count(database: store.Store) -> bool:
    """Whether the database has learned, and has kept the counts that it learned from."""
    if not store.is_learned(database):
        return False
    return bool(store.load_parameters(database, "counted_pairs"))


def recognise_captures(
    database: store.Store,
    symbols: MotionSymbols,
    arrays: Mapping[str, FloatArray],
    captures: Iterable[int],
) -> SegmentTable:
    """Cut and score stored captures by the learned symbols, as ``learn`` does at its end.

    arrays : the parameters of what was learned. Columns of movement that it does not know (an older
        motiondb learned it) are left out.
    """
    space = feature_space.FeatureSpace(arrays["feature_mean"], arrays["feature_projection"])
    settings = recut_settings(arrays)
    tables = []
    for capture in captures:
        motion = store.load_motion(database, capture)
        features = recognition_features(motion)
        bounds = np.array([0, len(features)])
        frames = space.project(features)
        pool = FeaturePool(np.array([capture]), bounds, features, np.array([motion.n_frames]))
        cutting = acquisition.recut(frames, bounds, symbols, settings)
        tables.append(segment_table(frames, pool, symbols, cutting))
    found = _join(*tables)
    known = len(arrays["score_mean"]) - symbols.n_symbols
    return replace(found, movement=found.movement[:, :known])


def unknown_words(
    database: store.Store, captures: Iterable[int], known: Iterable[str]
) -> tuple[str, ...]:
    """Words in the captions of captures that the vocabulary lacks, sorted."""
    synonyms, vocabulary_words = store.load_synonyms(database), set(known)
    captions = store.load_captions(database)
    found: set[str] = set()
    for capture in captures:
        for caption in captions.get(capture, ()):
            found |= set(vocabulary.words_of(caption.words, synonyms)) - vocabulary_words
    return tuple(sorted(found))


def _publish(
    learning: Learning,
    run_id: int,
    table: SegmentTable,
    counts: counting.Counts,
    reference: counting.Reference,
) -> Learning:
    parameters: dict[str, FloatArray] = dict(learning.parameters)
    ridge, calibration = parameters.get("word_ridge"), parameters.get("word_calibration")
    parameters |= counting.publish_parameters(
        counts, None if ridge is None else float(ridge), calibration
    )
    parameters |= counting.pack(counts, reference)
    return replace(
        learning,
        run_id=run_id,
        segments=table,
        association=counting.publish_association(counts, reference),
        transition_counts=counts.transitions,
        parameters=parameters,
    )


def _count(
    database: store.Store, table: SegmentTable, reference: counting.Reference
) -> counting.Counts:
    captions: Mapping[int, tuple[Caption, ...]] = store.load_captions(database)
    there = set(table.capture_ids.tolist())
    captions = {capture: rows for capture, rows in captions.items() if capture in there}
    return counting.count(table, captions, store.load_synonyms(database), reference)


def _only(table: SegmentTable, captures: set[int]) -> SegmentTable:
    which = np.isin(table.capture_ids, np.array(sorted(captures), dtype=np.int64))
    return counting.take_rows(table, which)


def _join(*tables: SegmentTable) -> SegmentTable:
    """Tables one after the other; capture numbers rise."""
    assert all(
        not len(a.capture_ids) or not len(b.capture_ids) or a.capture_ids[-1] < b.capture_ids[0]
        for a, b in pairwise(tables)
    )
    filled = [table for table in tables if len(table.capture_ids)] or list(tables[:1])
    columns = zip(*(vars(table).values() for table in filled))
    return SegmentTable(*(np.concatenate(column) for column in columns))
