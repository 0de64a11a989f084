"""Scenes as pictures: who is where, from above and from the half line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motiondb.body import pose_vectors, rotation
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.errors import MotionDBError
from motiondb.pictures import draw_scene_animation, save_png
from motiondb.pictures.scenes import performer_colours, scene_images, scene_paths_figure
from motiondb.records import Motion

DIAGRAM = read_scene_text("give-and-go").diagram


def standing(x: float, z: float, heading: float, n_frames: int = 31, speed: float = 0.0) -> Motion:
    turns = np.tile(rotation.IDENTITY, (n_frames, 21, 1))
    turns[:, 0] = pose_vectors.yaw(np.full(n_frames, heading))
    steps = speed / 30.0 * np.arange(n_frames)
    places = np.stack(
        [x + steps * np.sin(heading), np.full(n_frames, 0.93), z + steps * np.cos(heading)], axis=1
    )
    return Motion(turns.astype(np.float32), places.astype(np.float32))


def people() -> dict[str, Motion]:
    return {"A1": standing(-3.0, 6.0, 0.5, speed=3.0), "D1": standing(3.0, 4.0, np.pi, 20)}


def test_ways_stand_in_metres_in_their_colours() -> None:
    figure = scene_paths_figure(DIAGRAM, people())
    ways = {line.get_gid(): line for line in figure.axes[0].lines if line.get_gid()}
    x, z = ways["way A1"].get_data()
    np.testing.assert_allclose([x[0], z[0]], [-3.0, 6.0], atol=1e-6)
    np.testing.assert_allclose(np.hypot(x[-1] + 3.0, z[-1] - 6.0), 3.0, atol=1e-5)
    assert ways["way A1"].get_color() == performer_colours(DIAGRAM)["A1"]
    assert len(set(performer_colours(DIAGRAM).values())) == len(DIAGRAM.players)
    assert "ball" not in ways


def test_a_ball_that_flies_is_dashed_where_it_flies() -> None:
    ball = np.zeros((31, 3))
    ball[10:21, 0] = np.linspace(0.0, 3.0, 11)
    ball[21:, 0] = 3.0
    figure = scene_paths_figure(DIAGRAM, people(), ball)
    held, flown = (line for line in figure.axes[0].lines if line.get_gid() == "ball")
    assert np.isfinite(flown.get_xdata()).nonzero()[0].tolist() == list(range(10, 21))
    assert np.isnan(held.get_xdata()).nonzero()[0].tolist() == list(range(11, 20))


def test_the_page_is_a_png(tmp_path: Path) -> None:
    with Image.open(save_png(scene_paths_figure(DIAGRAM, people()), tmp_path / "p.png")) as image:
        assert image.width > 600


@pytest.mark.parametrize("above", [True, False])
def test_everybody_is_seen_where_they_are(above: bool) -> None:
    images = scene_images(DIAGRAM, people(), above=above, width=320)
    assert len(images) == 21  # 31 frames at 30 a second, 20 pictures a second
    pixels = np.asarray(images[0].convert("RGB")).astype(int)
    columns = {}
    for name, colour in performer_colours(DIAGRAM).items():
        if name in people():
            wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
            near = np.abs(pixels - wanted).sum(axis=2) < 60
            near[: pixels.shape[0] // 3] &= name != "A1"  # the rim has its colour
            columns[name] = float(np.median(np.nonzero(near)[1]))
    assert columns["A1"] < columns["D1"]


def test_who_ends_early_stands() -> None:
    moving = {"A1": standing(0.0, 4.0, 0.0, 10, speed=3.0), "D1": standing(3.0, 4.0, 0.0, 31)}
    images = scene_images(DIAGRAM, moving, width=240)
    height = images[0].height
    last, before = (np.asarray(image)[height // 8 :] for image in (images[-1], images[-6]))
    np.testing.assert_array_equal(last, before)


def test_a_gif_runs_in_real_time(tmp_path: Path) -> None:
    with Image.open(
        draw_scene_animation(DIAGRAM, people(), tmp_path / "a.gif", width=200)
    ) as image:
        durations = []
        for frame in range(image.n_frames):
            image.seek(frame)
            durations.append(image.info["duration"])
    assert sum(durations) == pytest.approx(1050)


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(MotionDBError, match="expected at least 1 character"):
        scene_paths_figure(DIAGRAM, {})
    with pytest.raises(MotionDBError, match=r"Z9: expected a player of the diagram \(A1, A2"):
        draw_scene_animation(DIAGRAM, {"Z9": standing(0, 0, 0)}, tmp_path / "p.gif")
    with pytest.raises(MotionDBError, match=r"ends in \.gif"):
        draw_scene_animation(DIAGRAM, people(), tmp_path / "p.mp4")
    with pytest.raises(MotionDBError, match="at most 120 s, found 12"):
        draw_scene_animation(DIAGRAM, {"A1": standing(0, 5, 0, 3700)}, tmp_path / "p.gif")
    assert list(tmp_path.iterdir()) == []
