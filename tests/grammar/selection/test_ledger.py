"""The ledger: bits of motion counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.selection import ledger
from motiondb.grammar.selection.ledger import motion_bits, performance_noise, rate, samples_a_frame


def test_motion_that_its_medoids_show_exactly_costs_the_medoids_and_the_lengths():
    # two terminals of one frame each, shown twice; poses 0 and 1, variance 1/4, delta^2 1/64
    values = np.array([[0.0], [1.0], [0.0], [1.0]])
    starts = np.arange(4)
    bits = motion_bits(values, starts, starts + 1, np.array([0, 1, 0, 1]), np.array([0, 1]), 0.125)
    # frames differ wholly from one to the next: one sample a frame; 2 frames of 1/2 log2 16 bits,
    # 4 lengths of 1 bit, 2 sizes told from 1 sample each
    assert bits == pytest.approx(2 * 2.0 + 4 * 1.0)


def test_what_a_warped_medoid_leaves_is_paid_for():
    values = np.array([[0.0], [4.0], [0.0], [0.0], [4.0], [8.0]])
    starts, ends = np.array([0, 2]), np.array([2, 6])
    one = motion_bits(values, starts, ends, np.array([0, 0]), np.array([0]), 0.5)
    # the longer is matched with 0, 0, 4, 4 of the shorter and leaves 0, 0, 0, 4
    samples = samples_a_frame(values)
    shown = 2 * 0.5 * np.log2(values.var() / 0.25)
    left = 4 * 0.5 * np.log2(16 / 4 / 0.25)
    size = 0.5 * np.log2(max(1.0, 4 * samples))
    assert one == pytest.approx((shown + left) * samples + size + 2 * np.log2(4))


def test_axes_share_the_error_that_is_allowed():
    # theta fills both axes with 1: 1/2 log2 4; the third, of 1/2, is not told at all
    assert rate(np.array([4.0, 0.5]), np.sqrt(1.5)) == pytest.approx(1.0)
    assert rate(np.array([0.5, 16.0, 4.0]), np.sqrt(2.5)) == pytest.approx(2.0 + 1.0)
    assert rate(np.array([1.0, 1.0]), np.sqrt(2.0)) == 0.0
    bisected = 0.5 * np.log2(np.maximum(np.array([9.0, 3.0, 1.0]) / level(), 1.0)).sum()
    assert rate(np.array([9.0, 3.0, 1.0]), 1.3) == pytest.approx(bisected)


def level():
    low, high = 0.0, 9.0
    for _ in range(80):
        middle = (low + high) / 2
        more = np.minimum(middle, [9.0, 3.0, 1.0]).sum() > 1.3**2
        low, high = (low, middle) if more else (middle, high)
    return low


def test_worse_medoids_cost_more_and_more_precision_too():
    rng = np.random.default_rng(0)
    centres = rng.normal(size=(3, 4)) * 5
    labels = rng.integers(0, 3, 30)
    values = np.repeat(centres[labels], 5, axis=0) + rng.normal(size=(150, 4)) * 0.1
    starts = np.arange(0, 150, 5)
    medoids = np.array([int(np.flatnonzero(labels == k)[0]) for k in range(3)])
    right = motion_bits(values, starts, starts + 5, labels, medoids, 0.3)
    wrong = motion_bits(values, starts, starts + 5, (labels + 1) % 3, np.roll(medoids, 1), 0.3)
    mixed = motion_bits(values, starts, starts + 5, np.zeros(30, int), medoids[:1], 0.3)
    assert right == pytest.approx(wrong)
    assert right < mixed
    assert right < motion_bits(values, starts, starts + 5, labels, medoids, 0.1)


def test_noise_is_what_tells_performances_of_one_action_apart():
    rng = np.random.default_rng(0)
    action = rng.normal(size=(60, 3)).cumsum(axis=0)
    off = np.array([0.3, 0.4, 0.0])
    values = np.concatenate([action, action + off])
    assert performance_noise(values, np.array([0, 60, 120])) == pytest.approx(0.5)
    spread = np.sqrt(values.var(axis=0).sum())
    twice = np.concatenate([action, action])
    assert performance_noise(twice, np.array([0, 60, 120])) < 0.05 * spread  # not below FINEST
    assert performance_noise(np.zeros((90, 2)), np.array([0, 90])) == 0.0
    short = rng.normal(size=(10, 2))
    assert performance_noise(short, np.array([0, 10])) == pytest.approx(
        ledger.COARSEST * np.sqrt(short.var(axis=0).sum())
    )


def test_motion_that_stands_still_costs_its_lengths_only():
    nothing = np.zeros((6, 2))
    one = np.array([0])
    assert motion_bits(nothing, one, one + 6, one, one, 0.1) == pytest.approx(np.log2(6))
    assert samples_a_frame(nothing) == 0.0


def test_a_precision_of_nothing_is_refused():
    with pytest.raises(GrammarError, match="expected metres above 0, found 0"):
        motion_bits(np.ones((2, 1)), np.array([0]), np.array([2]), np.array([0]), np.array([0]), 0)
