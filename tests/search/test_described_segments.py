"""The words of segments: captions of intervals, aligned captions of whole takes, and the motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.database.loading import nearby_table
from motiondb.learn.learned import Learned
from motiondb.meaning.score_vectors import interval_vectors
from motiondb.meaning.word_evidence import WINDOW_MARGIN
from motiondb.records import Caption
from motiondb.search.asked_words import learned_words, with_replaced
from motiondb.search.described import segment_words, word_probabilities
from motiondb.search.takings import Sentence, unknown_words


@pytest.fixture
def learned(learned_file: Path) -> Learned:
    with motiondb.open(learned_file, read_only=True) as db:
        return db.learned


def _capture(learned: Learned, name: str) -> int:
    return next(c for c in learned.rows if learned.captures[c].name == name)


def _with_captions(learned: Learned, capture: int, captions: tuple[Caption, ...]) -> Learned:
    return replace(learned, captions={**learned.captions, capture: captions})


def _by_motion(learned: Learned, capture: int) -> np.ndarray:
    rows = learned.rows[capture]
    starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
    vectors = [
        interval_vectors(
            learned.segment_rows[rows], starts, ends,
            np.array([start - WINDOW_MARGIN]), np.array([end + WINDOW_MARGIN]),
        )
        for start, end in zip(starts, ends)
    ]  # fmt: skip
    return word_probabilities(learned, np.concatenate(vectors)) * learned.is_known()


def test_words_that_no_caption_of_the_take_lists_are_those_of_the_motion(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    assert learned.places is not None
    words = segment_words(learned_words(learned), capture)
    others = np.ones(words.probabilities.shape[1], bool)
    others[list(learned.places.words[capture])] = False
    by_motion = _by_motion(learned, capture)
    np.testing.assert_allclose(words.probabilities[:, others], by_motion[:, others], atol=1e-9)
    assert not words.aligned[:, others].any()
    assert words.probabilities.min() >= 0.0
    assert words.probabilities.max() <= 1.0


def test_the_alignment_of_a_whole_caption_counts_where_it_says_more(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    whole = (Caption("walks, sits down, waves"),)
    changed = _with_captions(learned, capture, whole)
    assert changed.places is not None
    words = segment_words(learned_words(changed), capture)
    listed = list(changed.places.words[capture])
    shown, by_motion = changed.places.shown[capture], _by_motion(changed, capture)[:, listed]
    np.testing.assert_allclose(words.probabilities[:, listed], np.maximum(shown, by_motion))
    np.testing.assert_array_equal(words.aligned[:, listed], shown > by_motion)
    assert words.aligned.any()


def test_a_caption_of_an_interval_says_where_its_words_are(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    parts = (Caption("bows", start=11.4, end=13.0), Caption("walks, bows"))
    changed = _with_captions(learned, capture, parts)
    words = segment_words(learned_words(changed), capture)
    bow = learned.word_numbers["bow"]
    said = changed.said_places[capture][:, bow] > 0.0
    assert said.any()
    assert not said.all()
    assert (words.probabilities[said, bow] == 1.0).all()
    assert not words.aligned[said, bow].any()
    assert (words.probabilities[~said, bow] < 1.0).any()
    assert words.aligned[:, learned.word_numbers["walk"]].any()


def test_words_that_no_caption_holds_any_more_are_left_out(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    bow = learned.word_numbers["bow"]
    counts = learned.association.counts.copy()
    counts[bow] = 0
    without = _with_captions(
        replace(learned, association=replace(learned.association, counts=counts)),
        capture,
        (Caption("walks"),),
    )
    assert (segment_words(learned_words(without), capture).probabilities[:, bow] == 0.0).all()


@pytest.mark.parametrize("calibrated", [True, False])
def test_a_taken_word_is_what_it_is_taken_as(learned: Learned, calibrated: bool) -> None:
    if not calibrated:  # as databases with a start, and of older versions
        learned = replace(learned, description_calibration=None)
    takings = unknown_words(Sentence(learned, "stroll"), nearby_table())
    taken = with_replaced(learned_words(learned), takings)
    assert takings["stroll"].is_taken
    capture = _capture(learned, "ana/walk_1")
    words = segment_words(taken, capture).probabilities
    plain = segment_words(learned_words(learned), capture).probabilities
    np.testing.assert_allclose(words[:, : plain.shape[1]], plain)
    assert words.shape[1] == plain.shape[1] + 1
    assert words[:, -1].max() > 0.3


def test_without_places_the_motion_says_everything(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    whole = (Caption("walks, sits down, waves"),)
    without = _with_captions(replace(learned, places=None), capture, whole)
    words = segment_words(learned_words(without), capture)
    np.testing.assert_allclose(words.probabilities, _by_motion(without, capture), atol=1e-9)
    assert not words.aligned.any()
