"""The symbol space: panels, points, ellipses, and labels that keep out of each other's way."""

from __future__ import annotations

import hand_made
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.patches import Ellipse

from motiondb.pictures.space import cluster_look, place_labels, space_figure


def labels_of(axes) -> list[str]:
    return [text.get_text() for text in axes.texts if text.get_gid() == "label"]


def test_two_dimensions_are_one_panel_with_words() -> None:
    figure = space_figure(hand_made.space(3, 2), ["walk", "", "jump"])
    (axes,) = figure.axes
    assert labels_of(axes) == ["0 walk", "1", "2 jump"]
    ellipses = [patch for patch in axes.patches if isinstance(patch, Ellipse)]
    # two sigma, then one sigma, of both clusters: full axes 4 sigma and 2 sigma, sigma = 2 and 1
    assert [(e.width, e.height) for e in ellipses] == [(8.0, 4.0), (4.0, 2.0)] * 2
    assert [abs(e.angle) for e in ellipses] == [90.0] * 4
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "cluster 0: 2",
        "cluster 1: 1",
    ]


def test_three_dimensions_add_two_small_panels() -> None:
    figure = space_figure(hand_made.space(4, 3), ["a", "b", "c", "d"])
    assert [axes.get_label() for axes in figure.axes] == [
        "dimensions 1 and 2",
        "dimensions 1 and 3",
        "dimensions 2 and 3",
    ]
    assert labels_of(figure.axes[2]) == ["0", "1", "2", "3"]


def test_one_dimension_is_drawn_on_a_line() -> None:
    (axes,) = space_figure(hand_made.space(5, 1)).axes
    heights = np.concatenate([points.get_offsets()[:, 1] for points in axes.collections])
    assert heights.tolist() == [0.0] * 5


def test_panels_have_one_scale_both_ways() -> None:
    for axes in space_figure(hand_made.space(9, 3)).axes:
        across, up = np.diff(axes.get_xlim())[0], np.diff(axes.get_ylim())[0]
        box = axes.get_window_extent()
        assert across / box.width == pytest.approx(up / box.height)


def test_clusters_keep_apart_where_colours_begin_again() -> None:
    looks = [cluster_look(cluster) for cluster in range(60)]
    assert len(set(looks)) == 60


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 12))
def test_labels_with_room_around_them_overlap_nothing(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    cells = rng.choice(49, size=n, replace=False)
    points = np.stack([cells % 7, cells // 7], axis=1) * 100.0 + rng.uniform(0, 10, (n, 2))
    sizes = np.stack([rng.uniform(10, 60, n), np.full(n, 12.0)], axis=1)
    middles = place_labels(points, sizes, 5.0, np.array([-99.0, -99.0]), np.array([800.0, 800.0]))
    low, high = middles - sizes / 2, middles + sizes / 2
    for i in range(n):
        assert not np.any(np.all((points + 5 > low[i]) & (points - 5 < high[i]), axis=1))
        for j in range(i):
            assert not np.all((low[i] < high[j]) & (low[j] < high[i]))
