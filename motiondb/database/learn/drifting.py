"""``drift``: how far a database has changed since it learned."""

from __future__ import annotations

from motiondb import store
from motiondb.learn import drift
from motiondb.learn.codec import from_values


def measure_drift(opened: store.Store) -> drift.Drift | None:
    """The drift since the database learned; None if it has not."""
    with store.reading(opened):
        if not store.is_learned(opened):
            return None
        values = store.load_parameters(opened, "drift_baseline", "lemmas")
        baseline = from_values(drift.DriftBaseline, values, "drift_baseline")
        lemmas = from_values(dict[str, str], values, "lemmas")
        captured = {i.capture_id for i in store.load_captures(opened) if i.kind == "captured"}
        captions = [
            caption
            for capture, rows in store.load_captions(opened).items()
            if capture in captured
            for caption in rows
        ]
        vocabulary = store.load_association(opened).words
        words = drift.count_word_use(captions, vocabulary, store.load_synonyms(opened), lemmas)
        return drift.measure_drift(store.load_segments(opened, scores=False), baseline, words)
