"""Trees and strings: every node in its place, no line through another's node, every span drawn."""

from __future__ import annotations

import hand_made
import numpy as np
import pytest
from matplotlib.figure import Figure

from motiondb.grammar.cfg.context_free import derive_by, read_grammar
from motiondb.pictures import (
    StringBar,
    TerminalCard,
    Timeline,
    TreePicture,
    style,
)
from motiondb.pictures.trees import strings_figure, trees_figure
from motiondb.records import Motion

GRAMMAR = read_grammar("S -> a F F d\nF -> X m X | X c\nX -> l r | r l | empty")
FULL = derive_by(GRAMMAR, (0, 1, 3, 4, 2, 3))
SHORT = derive_by(GRAMMAR, (0, 1, 5, 4, 2, 3))


def texts(figure: Figure, kind: str) -> list[str]:
    return [t.get_text() for axes in figure.axes for t in axes.texts if t.get_gid() == kind]


def count(figure: Figure, kind: str) -> int:
    return sum(child.get_gid() == kind for axes in figure.axes for child in axes.get_children())


def test_a_tree_has_its_nodes_and_its_string_below() -> None:
    figure = trees_figure([TreePicture("one", FULL), TreePicture("two", SHORT)], "dance")
    assert texts(figure, "caption") == ["one", "two"]
    assert count(figure, "terminal") == 10 + 8
    assert count(figure, "edge") == 15 + 13
    first = figure.axes[0]
    symbols = [t for t in first.texts if t.get_gid() == "symbol"]
    assert [t.get_text() for t in symbols] == [node.symbol for node in FULL.nodes()]
    foot = max(t.get_position()[1] for t in symbols)
    below = sorted(
        (t for t in symbols if t.get_position()[1] == foot), key=lambda t: t.get_position()
    )
    assert tuple(t.get_text() for t in below) == FULL.leaves()
    assert np.allclose(np.diff([t.get_position()[0] for t in below]), 0.34)


def test_a_parent_stands_over_the_middle_of_its_children() -> None:
    figure = trees_figure([TreePicture("", FULL)])
    at = {t.get_text(): t.get_position() for t in figure.axes[0].texts if t.get_gid() == "symbol"}
    assert at["S"][0] == pytest.approx((at["a"][0] + at["d"][0]) / 2)
    assert at["S"][1] < at["F"][1] < at["X"][1] < at["a"][1]


def test_strings_show_cards_bars_and_times() -> None:
    cards = [
        TerminalCard(name, words, k, hand_made.swing(20))
        for k, (name, words) in enumerate([("a", "walk"), ("b", "a very long text " * 5)])
    ]
    spans = [(0.0, 12.0, "a", 0), (12.0, 23.0, "b", 1)]
    bars = [
        StringBar("one", 23.0, [Timeline("terminals", spans)]),
        StringBar("two", 9.0, [Timeline("terminals", [(0.0, 9.0, "a", 0)])]),
    ]
    figure = strings_figure(cards, bars, "dance")
    assert texts(figure, "name") == ["a", "b"]
    assert texts(figure, "words")[0] == "walk"
    assert texts(figure, "words")[1].endswith("…")
    assert count(figure, "figure") == 6
    assert texts(figure, "label") == ["a", "b", "b", "a"]  # 12-20 s, and 20-23 s in a second row
    times = [t.get_text() for t in figure.texts if t.get_text().endswith(" s")]
    assert times == [f"{s} s" for s in (0, 5, 10, 15, 20, 20, 0, 5)]


@pytest.mark.parametrize("motion", [hand_made.rest(20), hand_made.swing(20)], ids=["wide", "slim"])
def test_figures_stay_in_their_card(motion: Motion) -> None:
    (axes,) = strings_figure([TerminalCard("a", "", 0, motion)], []).axes
    drawn = [child for child in axes.get_children() if child.get_gid() == "figure"]
    sides = [(x.min(), x.max()) for x in (np.array(d.get_segments())[..., 0] for d in drawn)]
    left, right = axes.get_xlim()
    room = 0.1 * (right - left)
    assert min(low for low, _ in sides) >= left - room
    assert max(high for _, high in sides) <= right + room
    middles = [(low + high) / 2 for low, high in sides]
    assert np.diff(middles).min() > 0.2 * (right - left)


def test_marked_nodes_are_drawn_strongly_and_equal_terminals_in_one_colour() -> None:
    figure = trees_figure([TreePicture("", FULL, range(2, 12))], colours={"l": 0, "r": 1})
    assert {line.get_color() for line in figure.axes[0].lines} == {style.GROUND, style.RIGHT}
    boxes = [p for p in figure.axes[0].patches if p.get_gid() == "terminal"]
    colours = [box.get_facecolor() for box in boxes]
    string = FULL.leaves()
    assert colours[string.index("l")] != colours[string.index("r")]
    assert len({colours[n] for n, symbol in enumerate(string) if symbol == "l"}) == 1


def test_many_trees_stand_on_shelves() -> None:
    trees = [TreePicture(f"sentence {n}", FULL) for n in range(7)]
    tops = [round(axes.get_position().y1, 6) for axes in trees_figure(trees).axes]
    assert len(set(tops)) > 1
