"""Terminals that may show one action: distances with mirror images, levels of joining."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.cluster.hierarchy import linkage
from scipy.spatial.distance import squareform

from motiondb.body import body, rotation
from motiondb.grammar.terminals.likeness import (
    class_levels,
    joinings,
    steepest,
    terminal_distances,
)
from motiondb.grammar.terminals.terminals import Terminals
from motiondb.records import Motion

LENGTH = 20
LIFTS = (("l_shoulder", 1.2), ("r_shoulder", -1.2), ("l_hip", 1.0), ("chest", 0.6))
"""The arms are lifted to both sides alike; the leg and the trunk move in ways of their own."""


def take_of(lifts):
    """A take in which a joint at a time turns up and back, about the axis ahead."""
    swing = np.sin(np.linspace(0.0, np.pi, LENGTH))
    rotations = np.zeros((LENGTH * len(lifts), len(body.JOINTS), 4), dtype=np.float32)
    rotations[..., 0] = 1.0
    for k, (joint, turn) in enumerate(lifts):
        turned = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), turn * swing)
        rotations[LENGTH * k : LENGTH * (k + 1), body.INDEX[joint]] = turned
    roots = np.tile(np.array([0.0, 1.0, 0.0], dtype=np.float32), (len(rotations), 1))
    return Motion(rotations, roots)


def terminals_of(labels):
    names = tuple("abcd"[: max(labels) + 1])
    starts = LENGTH * np.arange(len(labels))
    firsts = np.array([labels.index(k) for k in range(len(names))])
    takes = np.zeros(len(labels), dtype=np.int64)
    return Terminals(names, takes, starts, starts + LENGTH, np.array(labels), firsts, 1.0)


@pytest.fixture(scope="module")
def lifted():
    labels = [0, 1, 2, 3, 1, 0, 3, 2]
    return take_of([LIFTS[k] for k in labels]), terminals_of(labels)


def test_the_left_arm_is_as_the_right_arm_in_the_mirror_and_the_leg_is_not(lifted):
    take, terminals = lifted
    apart = terminal_distances([take], terminals)
    assert (apart == apart.T).all()
    assert (np.diag(apart) == 0.0).all()
    others = apart[~np.eye(4, dtype=bool)]
    assert apart[0, 1] < 0.2 * np.sort(others)[2]


def test_the_arms_are_proposed_as_one_class(lifted):
    take, terminals = lifted
    assert class_levels([take], terminals)[0] == (("a", "b"), ("c",), ("d",))


def test_joinings_worked_by_hand():
    # 0 and 1 join at 1, 2 and 3 at 2; the two pairs at their farthest, 9
    apart = np.array([[0, 1, 5, 9], [1, 0, 4, 8], [5, 4, 0, 2], [9, 8, 2, 0]], dtype=float)
    joined = joinings(apart)
    assert joined == [
        (1.0, ((0, 1), (2,), (3,))),
        (2.0, ((0, 1), (2, 3))),
        (9.0, ((0, 1, 2, 3),)),
    ]
    assert steepest(joined, 3) == [((0, 1), (2,), (3,))]  # of two classes none is proposed


def test_no_level_has_fewer_classes_than_half_the_terminals():
    # 0 to 4 lie together, 5 to 7 apart; the steepest step, from 4 classes to 3, is within the bound
    places = np.array([0.0, 1.0, 2.1, 3.3, 4.6, 100.0, 300.0, 900.0])
    proposed = steepest(joinings(np.abs(places[:, None] - places)), 8)
    assert min(map(len, proposed)) == 4
    assert proposed[0] == ((0, 1, 2, 3, 4), (5,), (6,), (7,))


@settings(deadline=None)
@given(st.integers(2, 9), st.integers(0, 2**31))
def test_joinings_rise_and_partition_as_complete_linkage_does(n, seed):
    apart = np.random.default_rng(seed).random((n, n))
    apart = np.triu(apart, 1) + np.triu(apart, 1).T
    joined = joinings(apart)
    heights = [height for height, _ in joined]
    assert heights == pytest.approx(linkage(squareform(apart), "complete")[:, 2].tolist())
    for number, (_, groups) in enumerate(joined, start=1):
        assert len(groups) == n - number
        assert sorted(k for group in groups for k in group) == list(range(n))
