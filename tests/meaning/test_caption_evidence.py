"""The map that tells words, fitted to the described intervals of a segment table."""

from __future__ import annotations

import numpy as np

from motiondb.meaning.counting import described_intervals
from motiondb.meaning.description_map import fit_description_map, map_descriptions
from motiondb.meaning.score_vectors import fit_score_space, unit
from motiondb.records import Caption, SegmentTable

PERFORMERS = {10: "ana", 11: "boris", 12: "ana"}


def three_captures() -> SegmentTable:
    """Captures of two segments of 30 frames (1 s) each."""
    ids, starts = np.array([10, 10, 11, 11, 12, 12]), np.tile([0, 30], 3)
    scores = np.random.default_rng(0).normal(size=(6, 4)).astype(np.float32)
    best = scores.argmax(axis=1)
    return SegmentTable(ids, starts, starts + 30, best, scores.max(axis=1), best * 0.0, scores)


def test_it_is_fitted_to_vectors_words_and_performers_of_the_intervals() -> None:
    """A whole capture, a first half, and a whole capture of which one word is not known."""
    table = three_captures()
    captions = {
        10: (Caption("walk", None, None),),
        11: (Caption("walk, jump", 0.0, 1.0),),
        12: (Caption("jump, somersault", None, None),),
    }
    space = fit_score_space(table.scores, table.ends - table.starts)
    described = described_intervals(table, captions, {})
    told = map_descriptions(table, described, space, {"walk": 0, "jump": 1}, PERFORMERS)
    assert told is not None
    rows = space.standardise(table.scores, None)
    vectors = unit(np.stack([rows[:2].sum(axis=0), rows[2], rows[4:].sum(axis=0)]))
    presence = np.array([[1, 0], [1, 1], [0, 1]], dtype=bool)
    fitted = fit_description_map(vectors, presence, np.array([0, 1, 0]))
    np.testing.assert_allclose(told.scores(vectors), fitted.scores(vectors), atol=1e-6)


def test_without_known_words_there_is_no_map() -> None:
    table = three_captures()
    captions = {10: (Caption("somersault", None, None),)}
    space = fit_score_space(table.scores, table.ends - table.starts)
    described = described_intervals(table, captions, {})
    assert map_descriptions(table, described, space, {"walk": 0}, PERFORMERS) is None
    assert map_descriptions(table, [], space, {"walk": 0}, PERFORMERS) is None
