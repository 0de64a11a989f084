"""Every kind of picture: written whole, the same each time; and what is refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import hand_made
import numpy as np
import pytest
from hand_made import DIAGRAM, people, rest, standing, swing
from matplotlib.figure import Figure
from PIL import Image

from motiondb import pictures
from motiondb.errors import MotionDBError
from motiondb.grammar.cfg.context_free import derive_by, read_grammar
from motiondb.pictures import stick, style
from motiondb.pictures.animation import animation_images
from motiondb.pictures.hits import cut_motion, hits_figure
from motiondb.pictures.space import space_figure
from motiondb.records import Match

TREE = pictures.TreePicture("one", derive_by(read_grammar("S -> a S | b"), (0, 1)))
WORDS = pictures.Timeline("words", [(0.0, 1.5, "$5 歩く_{x", "walk")])
CARD = pictures.TerminalCard("a", "walk", 0, swing(20))
HIT = Match(1, "16/16_01", 1.0, 2.0, 0.912345, ("walk", "swing"))
Draw = Callable[[Path], Path]
PNG: dict[str, Callable[[], Figure]] = {
    "strip": lambda: pictures.strip_figure(swing(45), "$a_b$", [WORDS]),
    "hits": lambda: pictures.hits_figure([(HIT, swing(60))], "walk"),
    "space": lambda: pictures.space_figure(hand_made.space(30, 3, 12), ["walk"] * 30),
    "tactics": lambda: pictures.tactics_figure(DIAGRAM),
    "trees": lambda: pictures.trees_figure([TREE], "many"),
    "strings": lambda: pictures.strings_figure([CARD], []),
    "scene": lambda: pictures.scene_paths_figure(DIAGRAM, people()),
}
GIF: dict[str, Draw] = {
    "animation": lambda p: pictures.draw_animation(swing(30), p, height=96),
    "scene": lambda p: pictures.draw_scene_animation(DIAGRAM, people(), p, width=200),
}


@pytest.mark.parametrize("kind", PNG)
def test_a_picture_is_written_whole_and_the_same_each_time(kind: str, tmp_path: Path) -> None:
    first, second = (pictures.save_png(PNG[kind](), tmp_path / name) for name in ("a.png", "b.png"))
    assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png"]
    with Image.open(first) as image:
        assert image.format == "PNG"
        assert image.width >= 4 * style.DOTS_PER_INCH


@pytest.mark.parametrize(("kind", "milliseconds"), [("animation", 1000), ("scene", 1050)])
def test_a_gif_runs_in_real_time(kind: str, milliseconds: int, tmp_path: Path) -> None:
    first, second = (GIF[kind](tmp_path / name) for name in ("a.gif", "b.gif"))
    assert first.read_bytes() == second.read_bytes()
    durations = []
    with Image.open(first) as image:
        assert image.info["loop"] == 0
        for frame in range(image.n_frames):
            image.seek(frame)
            durations.append(image.info["duration"])
    assert sum(durations) == pytest.approx(milliseconds)


NAN = replace(rest(2), root_positions=rest(2).root_positions * np.float32(np.nan))
REFUSED: dict[str, Draw] = {
    "/no; make it first.": (
        lambda p: pictures.save_png(pictures.strip_figure(rest(2)), p / "no" / "a.png")
    ),
    "expected at least one tree to draw, found none": lambda _: pictures.trees_figure([]),
    "expected terminals or strings to draw, found none": (
        lambda _: pictures.strings_figure([], [])
    ),
    "a: expected an interval within its 3.00 s, found one from 3.00 s on. Run motiondb learn": (
        lambda _: cut_motion(swing(90), Match(1, "a", 3.0, 4.0, 0.0))
    ),
    "hits: expected at least 1 hit, found 0. Search for something else.": lambda _: hits_figure([]),
    "expected a name that ends in .gif, found '.mp4'. Animations are written as GIF.": (
        lambda p: pictures.draw_animation(rest(3), p / "a.mp4")
    ),
    "animation: expected at most 60 s, found 61.0 s. Choose an interval with --from and --to.": (
        lambda _: animation_images(rest(1830))
    ),
    "picture: expected a motion of at least 1 frame, found 0. Choose a longer interval.": (
        lambda _: stick.view_motion(rest(0))
    ),
    "picture: expected finite rotations and positions, found NaN or infinity. Add the capture": (
        lambda _: stick.view_motion(NAN)
    ),
    "symbol space: expected at least 1 symbol, found 0. Run learn first.": (
        lambda _: space_figure(hand_made.space(0, 2))
    ),
    "symbol space: expected 3 labels, one a symbol, found 1. Run motiondb learn again, so that": (
        lambda _: space_figure(hand_made.space(3, 2), ["walk"])
    ),
    "expected at least 1 character": lambda _: pictures.scene_paths_figure(DIAGRAM, {}),
    "Z9: expected a player of the diagram (A1, A2": (
        lambda p: pictures.draw_scene_animation(DIAGRAM, {"Z9": standing(0, 0, 0)}, p / "p.gif")
    ),
    "at most 120 s, found 12": (
        lambda p: pictures.draw_scene_animation(
            DIAGRAM, {"A1": standing(0, 5, 0, 3700)}, p / "p.gif"
        )
    ),
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_makes_no_picture_is_refused_and_nothing_is_written(text: str, tmp_path: Path) -> None:
    with pytest.raises(MotionDBError, match=re.escape(text)):
        REFUSED[text](tmp_path)
    assert list(tmp_path.iterdir()) == []
