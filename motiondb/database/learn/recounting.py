"""The learned model after captures and words have changed, without learning again.

Before the change, the counts of the captures that will change are subtracted. After it, the
captures that are there are counted (new captures are first cut and scored by the learned symbols),
and everything that follows from the counts is saved in the same transaction. Counts are exact
(:mod:`motiondb.meaning.counting`), so that a capture that was added and removed leaves no trace.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.database.loading import segments_of
from motiondb.language import vocabulary
from motiondb.learn.joining import with_counts
from motiondb.learn.learned_model import LearnedModel, from_stored, to_stored
from motiondb.learn.recognition import recognise_capture
from motiondb.meaning import counting
from motiondb.records import SegmentTable

if TYPE_CHECKING:
    from motiondb.database.learn.updating import Change


@contextmanager
def recounted(opened: store.Store, change: Change, wanted: set[int]) -> Iterator[None]:
    """Update the learned model after a change of captures or words.

    The segments of the captures that stay are not saved again.

    `wanted`: Numbers of the captures that change.
    """
    stored = store.load_learning(opened, scores=False)
    model = from_stored(stored)
    counts, reference = model.counted.counts, model.counted.reference
    known = set(model.segments.capture_ids.tolist())
    wanted = wanted & known
    before = segments_of(opened, model, wanted)
    counts = counts - _count(opened, before, reference)
    yield
    there = {*store.load_captured(opened)}
    new, kept = sorted(set(change.added) & there), known & there
    if not new and not wanted:
        return
    recognised = [recognise_capture(model, c, store.load_motion(opened, c)) for c in new]
    added = counting.join_tables(_only(before, set()), *recognised)
    again = counting.join_tables(_only(before, there), added)
    counts = counts + _count(opened, again, reference)
    change.counted = tuple(counting.capture_rows(again))
    change.new_words = _unknown_words(opened, change.counted, model)
    counted = counting.Counted(counts, reference)
    model = with_counts(replace(model, segments=added), change.run_id, kept | set(new), counted)
    store.save_learning(opened, to_stored(model), kept, stored)


def _unknown_words(
    opened: store.Store, captures: Iterable[int], model: LearnedModel
) -> tuple[str, ...]:
    """Words in the captions of captures that the vocabulary lacks, sorted."""
    synonyms, known = store.load_synonyms(opened), set(model.association.words)
    captions = store.load_captions(opened, captures)
    unknown: set[str] = set()
    for capture in captures:
        for caption in captions.get(capture, ()):
            unknown |= set(vocabulary.words_of(caption.words, synonyms, model.lemmas)) - known
    return tuple(sorted(unknown))


def _count(
    opened: store.Store, table: SegmentTable, reference: counting.Reference
) -> counting.Counts:
    captions = store.load_captions(opened, set(table.capture_ids.tolist()))
    return counting.count(table, captions, store.load_synonyms(opened), reference)


def _only(table: SegmentTable, captures: set[int]) -> SegmentTable:
    which = np.isin(table.capture_ids, np.array(sorted(captures), dtype=np.int64))
    return counting.take_rows(table, which)
