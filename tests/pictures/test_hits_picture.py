"""Rows of hits and of motions to compare, and moving pictures."""

from __future__ import annotations

from dataclasses import replace

import hand_made
import numpy as np

from motiondb.pictures.animation import animation_images
from motiondb.pictures.hits import cut_motion, hit_label, hits_figure
from motiondb.records import Match, MatchPart

HIT = Match(1, "16/16_01", 1.0, 2.0, 0.912345, ("walk", "swing"), "", 0.9)


def figures(axes) -> int:
    return sum(child.get_gid() == "figure" for child in axes.collections)


def test_a_row_for_the_example_and_for_every_hit() -> None:
    motion = hand_made.swing(90)
    far = Match(2, "16/16_02", 2.9, 9.9, 0.5, (), "moves like it")
    figure = hits_figure([(HIT, motion), (far, motion)], "walk", ("query.bvh", motion))
    rows = [axes for axes in figure.axes if axes.get_label() != "path"]
    assert [axes.get_label() for axes in rows] == ["query.bvh", "1  16/16_01", "2  16/16_02"]
    assert [figures(axes) for axes in rows] == [7, 7, 3]
    # frames 30 to 59 of the capture, told in its own seconds
    times = [text.get_text() for text in rows[1].texts]
    assert times == ["1.0 s", "1.2 s", "1.3 s", "1.5 s", "1.6 s", "1.8 s", "2.0 s"]
    shown = [text.get_text() for text in figure.texts]
    assert shown[0] == "walk"
    assert "1.0 – 2.0 s,  probability 0.90\nwalk, swing" in shown
    assert {"left limbs", "right limbs"} <= set(shown)
    assert "2.9 – 9.9 s,  probability -\nmoves like it" in shown


def test_the_parts_of_a_sequence_are_marked_where_they_are() -> None:
    parts = (MatchPart("walk", 1.0, 1.5), MatchPart("jump", 1.5, 2.0))
    row, path = hits_figure([(replace(HIT, parts=parts), hand_made.swing(90))]).axes
    marks = [line.get_xdata() for line in row.lines if line.get_gid() == "part"]
    low, high = row.get_xlim()
    assert low < marks[0][0] < marks[0][1] == marks[1][0] < marks[1][1] < high
    assert {text.get_text() for text in row.texts} >= {"walk", "jump"}
    assert (path.get_label(), len(path.lines)) == ("path", 2)


def test_many_words_are_shortened() -> None:
    long = Match(3, "a", 0.0, 1.0, 1.0, tuple("abcdefghijklmnopqrstuvwxyz"))
    assert hit_label(long).splitlines()[2] == "a, b, c, d, e, f, g, h, i, j, k, l, m, n,…"


def test_the_frames_of_a_hit() -> None:
    motion = hand_made.swing(90)
    assert np.array_equal(cut_motion(motion, HIT).root_positions, motion.root_positions[30:60])
    assert cut_motion(motion, Match(1, "a", 1.0, 1.0, 0.0)).n_frames == 1


def test_a_still_body_moves_over_the_ground() -> None:
    first, last = (np.asarray(image) for image in animation_images(hand_made.swing(16), 96)[::10])
    assert first.shape == last.shape == (96, 96)
    assert not np.array_equal(first, last)
