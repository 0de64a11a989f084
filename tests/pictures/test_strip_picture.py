"""Strips and timelines: how much is drawn, where, and what is refused."""

from __future__ import annotations

from itertools import pairwise

import hand_made
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from motiondb.pictures import Timeline
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
    figure = strip_figure(hand_made.swing(90), "a walk", [SYMBOLS, WORDS])
    assert [axes.get_label() for axes in figure.axes] == [
        "figures 0",
        "symbols 0",
        "words 0",
        "time 0",
    ]
    assert count(figure, "span") == 4
    assert texts(figure, "label") == ["17", "4", "walk", "swing arms"]
    assert figure.texts[0].get_text() == "a walk"
    assert figure.axes[1].get_xlim() == (0.0, 3.0)


def test_figures_stand_over_their_times_in_true_proportion() -> None:
    figure = strip_figure(hand_made.swing(90))
    axes = figure.axes[0]
    width, height = axes.get_window_extent().size
    metres = axes.get_xlim()[1]
    assert metres / width == pytest.approx((axes.get_ylim()[1] - axes.get_ylim()[0]) / height)
    shadows = [patch for patch in axes.patches if patch.get_facecolor()[:3] != (1.0, 1.0, 1.0)]
    places = [shadow.get_center()[0] for shadow in shadows]
    n = len(places)
    assert places == pytest.approx([(k + 0.5) / n * metres for k in range(n)])


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
    figure = strip_figure(hand_made.swing(900), timelines=[words])
    limits = [axes.get_xlim() for axes in figure.axes if axes.get_label().startswith("words")]
    assert limits == [(0.0, 10.0), (10.0, 20.0), (20.0, 30.0)]
    assert count(figure, "span") == 3
    in_a_row = count(figure, "figure") / 3
    shorter = strip_figure(hand_made.swing(735))  # rows of 9 s, of which the last is not full
    assert 2 * in_a_row < count(shorter, "figure") < 3 * in_a_row


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
