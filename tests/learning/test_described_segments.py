"""The words of segments: captions of intervals, aligned captions of whole takes, and the motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.learning.answers.described_motion import word_probabilities
from motiondb.learning.answers.described_segments import segment_words
from motiondb.learning.learned import Learned
from motiondb.records import Caption
from motiondb.search.questions.by_words import WINDOW_MARGIN
from motiondb.search.vectors.score_vectors import interval_vectors


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
            learned.standardised[rows], starts, ends,
            np.array([start - WINDOW_MARGIN]), np.array([end + WINDOW_MARGIN]),
        )
        for start, end in zip(starts, ends)
    ]  # fmt: skip
    return word_probabilities(learned, np.concatenate(vectors)) * learned.is_known()


def test_words_that_no_caption_of_the_take_lists_are_those_of_the_motion(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    assert learned.places is not None
    words = segment_words(learned, capture)
    others = np.ones(words.probabilities.shape[1], bool)
    others[list(learned.places.words[capture])] = False
    by_motion = _by_motion(learned, capture)
    np.testing.assert_allclose(words.probabilities[:, others], by_motion[:, others], atol=1e-9)
    assert not words.aligned[:, others].any()
    assert words.probabilities.min() >= 0.0
    assert words.probabilities.max() <= 1.0


def test_the_alignment_of_a_whole_caption_counts_where_it_says_more(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    assert learned.places is not None
    whole = (Caption("walks, sits down, waves"),)
    words = segment_words(_with_captions(learned, capture, whole), capture)
    listed = list(learned.places.words[capture])
    shown, by_motion = learned.places.shown[capture], _by_motion(learned, capture)[:, listed]
    np.testing.assert_allclose(words.probabilities[:, listed], np.maximum(shown, by_motion))
    np.testing.assert_array_equal(words.aligned[:, listed], shown > by_motion)
    assert words.aligned.any()


def test_a_caption_of_an_interval_says_where_its_words_are(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    assert learned.places is not None
    parts = (Caption("waves", start=11.4, end=13.0), Caption("walks, waves"))
    words = segment_words(_with_captions(learned, capture, parts), capture)
    wave = learned.word_numbers["wave"]
    listed = learned.places.words[capture]
    shown = learned.places.shown[capture][:, listed.index(wave)]
    np.testing.assert_array_equal(words.probabilities[:, wave], shown)
    assert not words.aligned[:, wave].any()
    assert words.aligned[:, learned.word_numbers["walk"]].any()


def test_without_places_the_motion_says_everything(learned: Learned) -> None:
    capture = _capture(learned, "ana/long_1")
    whole = (Caption("walks, sits down, waves"),)
    without = _with_captions(replace(learned, places=None), capture, whole)
    words = segment_words(without, capture)
    np.testing.assert_allclose(words.probabilities, _by_motion(learned, capture), atol=1e-9)
    assert not words.aligned.any()
