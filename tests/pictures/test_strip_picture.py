"""Strips and timelines: how much is drawn, where, and what is refused."""

from __future__ import annotations

from itertools import pairwise

import hand_made
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from PIL import Image

from motiondb.errors import MotionDBError
from motiondb.pictures import Timeline, save_png, style
from motiondb.pictures.strip import lanes, n_lanes, strip_figure

SYMBOLS = Timeline("symbols", [(0.0, 1.0, "17", 17), (1.0, 3.0, "4", 4)])
WORDS = Timeline("words", [(0.0, 2.0, "walk", "walk"), (0.5, 3.0, "swing arms", "swing arms")])


def texts(figure: Figure, kind: str) -> list[str]:
    return [
        text.get_text() for axes in figure.axes for text in axes.texts if text.get_gid() == kind
    ]


def count(figure: Figure, kind: str) -> int:
    return sum(child.get_gid() == kind for axes in figure.axes for child in axes.get_children())


def test_a_strip_has_its_figures_spans_and_labels() -> None:
    figure = strip_figure(hand_made.swing(90), "a walk", [SYMBOLS, WORDS], n_figures=8)
    assert [axes.get_label() for axes in figure.axes] == [
        "figures 0",
        "symbols 0",
        "words 0",
        "time 0",
    ]
    assert count(figure, "figure") == 8
    assert count(figure, "span") == 4
    assert texts(figure, "label") == ["17", "4", "walk", "swing arms"]
    assert figure.texts[0].get_text() == "a walk"
    assert figure.axes[1].get_xlim() == (0.0, 3.0)


def test_figures_stand_over_their_times_in_true_proportion() -> None:
    figure = strip_figure(hand_made.swing(90), n_figures=3)
    axes = figure.axes[0]
    width, height = axes.get_window_extent().size
    metres = axes.get_xlim()[1]
    assert metres / width == pytest.approx((axes.get_ylim()[1] - axes.get_ylim()[0]) / height)
    shadows = [patch for patch in axes.patches if patch.get_facecolor()[:3] != (1.0, 1.0, 1.0)]
    places = [shadow.get_center()[0] for shadow in shadows]
    assert places == pytest.approx([metres / 6, metres / 2, 5 * metres / 6])


def test_figures_side_by_side_do_not_overlap() -> None:
    axes = strip_figure(hand_made.rest(60)).axes[0]
    heaps = [child for child in axes.collections if child.get_gid() == "figure"]
    spans = sorted(
        (
            min(p[:, 0].min() for p in heap.get_segments()),
            max(p[:, 0].max() for p in heap.get_segments()),
        )
        for heap in heaps
    )
    assert len(spans) >= 3
    assert all(before[1] <= after[0] + 0.1 for before, after in pairwise(spans))


def test_a_long_capture_takes_rows_of_whole_seconds_and_spans_go_on() -> None:
    words = Timeline("words", [(5.0, 29.0, "walk", "walk")])
    figure = strip_figure(hand_made.swing(30 * 30), timelines=[words], n_figures=4)
    limits = [axes.get_xlim() for axes in figure.axes if axes.get_label().startswith("words")]
    assert limits == [(0.0, 10.0), (10.0, 20.0), (20.0, 30.0)]
    assert count(figure, "span") == 3
    assert count(figure, "figure") == 12


def test_a_row_that_is_not_full_has_fewer_figures() -> None:
    figure = strip_figure(hand_made.swing(75), n_figures=4, seconds_per_row=2.0)
    heaps = [sum(c.get_gid() == "figure" for c in axes.collections) for axes in figure.axes]
    assert heaps == [4, 0, 1, 0]


def test_a_single_frame_is_one_figure() -> None:
    assert count(strip_figure(hand_made.rest(1)), "figure") == 1


def test_the_picture_is_written_whole_and_the_same_each_time(tmp_path) -> None:
    motion = hand_made.swing(45)
    timelines = [SYMBOLS, Timeline("words", [(0.0, 1.5, "$5 歩く_{x", "walk")])]
    first = save_png(strip_figure(motion, "$a_b$", timelines), tmp_path / "a.png")
    second = save_png(strip_figure(motion, "$a_b$", timelines), tmp_path / "b.png")
    assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png"]
    with Image.open(first) as image:
        assert image.format == "PNG"
        assert image.width == 12 * style.DOTS_PER_INCH


def test_a_folder_that_is_not_there(tmp_path) -> None:
    path = tmp_path / "no" / "a.png"
    with pytest.raises(MotionDBError) as caught:
        save_png(strip_figure(hand_made.rest(2)), path)
    assert str(caught.value) == (
        f"{path}: expected a file that can be written, found: No such file or directory. "
        "Check the folder and the room on its disk."
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"n_figures": 0},
            "strip: expected at least 1 figure in a row, found 0. Ask for more.",
        ),
        (
            {"seconds_per_row": 0.0},
            "strip: expected a row of more than 0 s, found 0.0. Ask for more.",
        ),
    ],
)
def test_numbers_that_make_no_picture(options, message, tmp_path) -> None:
    with pytest.raises(MotionDBError) as caught:
        strip_figure(hand_made.rest(2), **options)
    assert str(caught.value) == message
    assert list(tmp_path.iterdir()) == []


span_lists = st.lists(
    st.tuples(st.floats(0, 10), st.floats(0.01, 5)).map(lambda s: (s[0], s[0] + s[1], "a", 0)),
    max_size=12,
)


@given(span_lists)
def test_lanes_never_overlap_and_are_as_few_as_can_be(spans) -> None:
    actual = lanes(spans)
    for i, a in enumerate(spans):
        for j, b in enumerate(spans[:i]):
            if actual[i] == actual[j]:
                assert a[1] <= b[0] + 1e-9 or b[1] <= a[0] + 1e-9
    crowd = [sum(b[0] <= a[0] < b[1] - 1e-9 for b in spans) for a in spans]
    assert n_lanes(Timeline("", spans)) == max(crowd, default=1)
