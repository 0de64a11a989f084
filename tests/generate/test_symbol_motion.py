"""What a made motion is heard to show, and that what is not heard is made anew."""

import numpy as np
import pytest

from motiondb.generate import symbol_motion


def test_clarity_of_a_stretch_is_the_mean_over_its_frames() -> None:
    probabilities = np.array([[0.5, 0.75], [0.25, 0.75]])
    expected = (np.log(0.5) + np.log(0.25)) / 2 + 0.5 * np.log(0.25)
    assert symbol_motion.log_clarity(probabilities, np.array([0])) == pytest.approx(expected)


def test_every_word_asked_for_is_to_be_heard() -> None:
    probabilities = np.array([[0.9, 0.3], [0.3, 0.3]])
    assert symbol_motion.shows_all(probabilities, [0], 0.6)
    assert not symbol_motion.shows_all(probabilities, [0], 0.61)
    assert not symbol_motion.shows_all(probabilities, [0, 1], 0.5)
