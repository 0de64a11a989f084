"""Rows of hits and of motions to compare, and moving pictures."""

from __future__ import annotations

import hand_made
import numpy as np
import pytest
from PIL import Image

from motiondb.errors import MotionDBError
from motiondb.pictures import draw_animation, save_png
from motiondb.pictures.animation import animation_images
from motiondb.pictures.hits import comparison_figure, cut_motion, hit_label, hits_figure
from motiondb.records import Match

HIT = Match(1, "16/16_01", 1.0, 2.0, 0.912345, ("walk", "swing"))


def figures(axes) -> int:
    return sum(child.get_gid() == "figure" for child in axes.collections)


def test_a_row_for_the_example_and_for_every_hit() -> None:
    motion = hand_made.swing(90)
    far = Match(2, "16/16_02", 2.9, 9.9, 0.5, (), "moves like it")
    figure = hits_figure([(HIT, motion), (far, motion)], "walk", ("query.bvh", motion), n_figures=5)
    assert [axes.get_label() for axes in figure.axes] == ["query.bvh", "1  16/16_01", "2  16/16_02"]
    assert [figures(axes) for axes in figure.axes] == [5, 5, 3]
    # frames 30 to 59 of the capture, told in its own seconds
    times = [text.get_text() for text in figure.axes[1].texts]
    assert times == ["1.0 s", "1.2 s", "1.5 s", "1.7 s", "2.0 s"]
    shown = [text.get_text() for text in figure.texts]
    assert shown[0] == "walk"
    assert "1.0 – 2.0 s,  score 0.912\nwalk, swing" in shown
    assert "2.9 – 9.9 s,  score 0.5\nmoves like it" in shown


def test_many_words_are_shortened() -> None:
    long = Match(3, "a", 0.0, 1.0, 1.0, tuple("abcdefghijklmnopqrstuvwxyz"))
    assert hit_label(long).splitlines()[2] == "a, b, c, d, e, f, g, h, i, j, k, l, m, n,…"


def test_the_frames_of_a_hit() -> None:
    motion = hand_made.swing(90)
    assert np.array_equal(cut_motion(motion, HIT).root_positions, motion.root_positions[30:60])
    assert cut_motion(motion, Match(1, "a", 1.0, 1.0, 0.0)).n_frames == 1
    with pytest.raises(MotionDBError) as caught:
        cut_motion(motion, Match(1, "a", 3.0, 4.0, 0.0))
    assert str(caught.value) == (
        "a: expected an interval within its 3.00 s, found one from 3.00 s on. Run motiondb learn "
        "again, so that search and captures agree."
    )


def test_no_hits_no_rows_no_figures() -> None:
    with pytest.raises(MotionDBError) as caught:
        hits_figure([])
    assert str(caught.value) == "hits: expected at least 1 hit, found 0. Search for something else."
    with pytest.raises(MotionDBError, match="comparison: expected at least 1 motion, found 0"):
        comparison_figure([])
    with pytest.raises(MotionDBError, match="expected at least 1 figure in a row, found 0"):
        comparison_figure([("a", hand_made.rest(3))], n_figures=0)


def test_pictures_are_the_same_each_time(tmp_path) -> None:
    motion = hand_made.swing(60)
    for name in ("a", "b"):
        save_png(hits_figure([(HIT, motion)], "walk"), tmp_path / f"{name}.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


def test_an_animation_plays_in_real_time(tmp_path) -> None:
    path = draw_animation(hand_made.swing(30), tmp_path / "a.gif", height=96)
    with Image.open(path) as image:
        assert image.format == "GIF"
        assert image.size == (96, 96)
        assert image.n_frames == 20
        assert image.info["duration"] == 50
        assert image.info["loop"] == 0
    again = draw_animation(hand_made.swing(30), tmp_path / "b.gif", height=96)
    assert path.read_bytes() == again.read_bytes()


def test_a_still_body_moves_over_the_ground() -> None:
    first, last = (np.asarray(image) for image in animation_images(hand_made.swing(16), 96)[::10])
    assert first.shape == last.shape == (96, 96)
    assert not np.array_equal(first, last)


def test_what_cannot_be_animated(tmp_path) -> None:
    with pytest.raises(MotionDBError) as caught:
        draw_animation(hand_made.rest(3), tmp_path / "a.mp4")
    assert str(caught.value) == (
        f"{tmp_path / 'a.mp4'}: expected a name that ends in .gif, found '.mp4'. "
        "Animations are written as GIF."
    )
    with pytest.raises(MotionDBError) as caught:
        animation_images(hand_made.rest(1830))
    assert str(caught.value) == (
        "animation: expected at most 60 s, found 61.0 s. Choose an interval with --from and --to."
    )
    with pytest.raises(MotionDBError, match="expected at least 64 pixels, found 10"):
        animation_images(hand_made.rest(3), 10)
    with pytest.raises(MotionDBError, match="expected a motion of at least 1 frame, found 0"):
        animation_images(hand_made.rest(0))
