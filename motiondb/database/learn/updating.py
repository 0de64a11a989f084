"""Updates of the learned model when captures and words change, without learning again.

One context manager surrounds every change of captures, words or synonyms. Before the change, the
counts of the captures that will change are subtracted. After it, the captures that are there are
counted (new captures are first cut and scored by the learned symbols), and everything that follows
from the counts is saved in the same transaction. Counts are exact
(:mod:`motiondb.meaning.counting`), so that a capture that was added and removed leaves no trace.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from motiondb import store
from motiondb.language import vocabulary
from motiondb.learn.joining import with_counts
from motiondb.learn.learned_model import LearnedModel, from_stored, to_stored
from motiondb.learn.recognition import recognise_capture
from motiondb.meaning import counting
from motiondb.meaning.counting import Counted
from motiondb.records import SegmentTable


@dataclass
class Change:
    """The result of counting a change of captures or words."""

    run_id: int  # The run that makes the change; ``undo`` takes it back
    # Numbers of the captures that the body of :func:`counted` adds; filled by the body
    added: list[int] = field(default_factory=list)
    counted: tuple[int, ...] = ()  # Numbers of the captures that were counted after the change
    # Words in their captions that the vocabulary lacks; the next ``learn`` counts them
    new_words: tuple[str, ...] = ()


@contextmanager
def changing(
    opened: store.Store, kind: str, parameters: Mapping[str, object], touched: Iterable[int] = ()
) -> Iterator[Change]:
    """A transaction with a separate run around :func:`counted`."""
    with store.transaction(opened):
        run_id = store.start_run(opened, kind, parameters)
        with counted(opened, run_id, touched) as change:
            yield change
        store.finish_run(opened, run_id)


@contextmanager
def counted(opened: store.Store, run_id: int, touched: Iterable[int] = ()) -> Iterator[Change]:
    """Surround a change of captures or words, inside a transaction, so that counts stay true.

    What was changed is noted, so that it can be undone. Nothing is counted if the database has not
    learned.
    """
    change, wanted = Change(run_id), set(touched)
    with store.noting_edits(opened, run_id, wanted), _counted(opened, change, wanted):
        yield change


@contextmanager
def _counted(opened: store.Store, change: Change, wanted: set[int]) -> Iterator[None]:
    """Update the learned model after a change of captures or words."""
    if not store.is_learned(opened):
        yield
        return
    model = from_stored(store.load_learning(opened))
    counts, reference = model.counted.counts, model.counted.reference
    table = model.segments
    wanted = wanted & set(table.capture_ids.tolist())
    counts = counts - _count(opened, _only(table, wanted), reference)
    yield
    there = {i.capture_id for i in store.load_captures(opened) if i.kind == "captured"}
    table = _only(table, there)
    new = sorted(set(change.added) & there)
    if not new and not wanted:
        return
    for capture in new:
        added = recognise_capture(model, capture, store.load_motion(opened, capture))
        table = counting.join_tables(table, added)
    again = _only(table, wanted | set(new))
    counts = counts + _count(opened, again, reference)
    change.counted = tuple(counting.capture_rows(again))
    change.new_words = _unknown_words(opened, change.counted, model)
    model = with_counts(model, change.run_id, table, Counted(counts, reference))
    store.save_learning(opened, to_stored(model))


def _unknown_words(
    opened: store.Store, captures: Iterable[int], model: LearnedModel
) -> tuple[str, ...]:
    """Words in the captions of captures that the vocabulary lacks, sorted."""
    synonyms, known = store.load_synonyms(opened), set(model.association.words)
    captions = store.load_captions(opened)
    unknown: set[str] = set()
    for capture in captures:
        for caption in captions.get(capture, ()):
            unknown |= set(vocabulary.words_of(caption.words, synonyms, model.lemmas)) - known
    return tuple(sorted(unknown))


def _count(
    opened: store.Store, table: SegmentTable, reference: counting.Reference
) -> counting.Counts:
    there = set(table.capture_ids.tolist())
    captions = {c: rows for c, rows in store.load_captions(opened).items() if c in there}
    return counting.count(table, captions, store.load_synonyms(opened), reference)


def _only(table: SegmentTable, captures: set[int]) -> SegmentTable:
    which = np.isin(table.capture_ids, np.array(sorted(captures), dtype=np.int64))
    return counting.take_rows(table, which)
