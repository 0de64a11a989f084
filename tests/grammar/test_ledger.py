"""The ledger: bits of motion counted by hand, and the choice of the number of terminals."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.grammar.cfg import GrammarError
from motiondb.grammar.ledger import motion_bits, samples_a_frame


def test_motion_that_its_medoids_show_exactly_costs_the_medoids_and_the_lengths():
    # two terminals of one frame each, shown twice; poses 0 and 1, variance 1/4, delta^2 1/16 of it
    values = np.array([[0.0], [1.0], [0.0], [1.0]])
    starts = np.arange(4)
    bits = motion_bits(values, starts, starts + 1, np.array([0, 1, 0, 1]), np.array([0, 1]), 0.25)
    # frames differ wholly from one to the next: one sample a frame; 2 frames of 1/2 log2 16 bits,
    # 4 lengths of 1 bit
    assert bits == pytest.approx(2 * 2.0 + 4 * 1.0)


def test_what_a_warped_medoid_leaves_is_paid_for():
    values = np.array([[0.0], [4.0], [0.0], [0.0], [4.0], [8.0]])
    starts, ends = np.array([0, 2]), np.array([2, 6])
    one = motion_bits(values, starts, ends, np.array([0, 0]), np.array([0]), 0.1)
    variance = values.var()
    # the longer is matched with 0, 0, 4, 4 of the shorter and leaves 0, 0, 0, 4
    shown = 2 * 0.5 * np.log2(1 / 0.01)
    left = 4 * 0.5 * np.log2(16 / 4 / (0.01 * variance))
    expected = (shown + left) * samples_a_frame(values) + 2 * np.log2(4)
    assert one == pytest.approx(expected)


def test_worse_medoids_cost_more_and_more_precision_too():
    rng = np.random.default_rng(0)
    centres = rng.normal(size=(3, 4)) * 5
    labels = rng.integers(0, 3, 30)
    values = np.repeat(centres[labels], 5, axis=0) + rng.normal(size=(150, 4)) * 0.1
    starts = np.arange(0, 150, 5)
    medoids = np.array([int(np.flatnonzero(labels == k)[0]) for k in range(3)])
    right = motion_bits(values, starts, starts + 5, labels, medoids)
    wrong = motion_bits(values, starts, starts + 5, (labels + 1) % 3, np.roll(medoids, 1))
    mixed = motion_bits(values, starts, starts + 5, np.zeros(30, int), medoids[:1])
    assert right == pytest.approx(wrong)
    assert right < mixed
    assert right < motion_bits(values, starts, starts + 5, labels, medoids, 0.01)


def test_motion_that_stands_still_costs_nothing():
    nothing = np.zeros((6, 2))
    one = np.array([0])
    assert motion_bits(nothing, one, one + 6, one, one) == 0.0
    assert samples_a_frame(nothing) == 0.0


def test_a_precision_of_nothing_is_refused():
    with pytest.raises(GrammarError, match="expected a share above 0, found 0"):
        motion_bits(np.ones((2, 1)), np.array([0]), np.array([2]), np.array([0]), np.array([0]), 0)
