"""The part of a capture in which most happens: thumbnails, the wall, posters of answers."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
from page_serving import Serve, get
from starlette.testclient import TestClient

import motiondb
from motiondb.page.motion import AT_EASE, POINTS, best_moment, read_tracks, shapes_of

HAND = POINTS.index("r_hand_end")


def standing(n_frames: int) -> np.ndarray:
    """Points of a body that stands still: (frames, 26, 3)."""
    return np.repeat(AT_EASE, n_frames, axis=0)


def test_standing_at_ease_is_the_pose_that_shows_nothing() -> None:
    head, left, right = (POINTS.index(f"{end}_end") for end in ("head", "l_hand", "r_hand"))
    assert 1.6 < AT_EASE[0, head, 1] < 1.9  # metres
    assert AT_EASE[0, left, 1] == AT_EASE[0, right, 1] < AT_EASE[0, 0, 1]
    assert shapes_of(standing(3))[1].tolist() == [0.0, 0.0, 0.0]


def test_the_best_part_is_where_the_body_moves() -> None:
    points = standing(100)
    points[60:70, HAND, 1] += np.linspace(0.1, 1.0, 10)  # a hand goes up in a third of a second
    points[70:, HAND, 1] += 1.0
    best = best_moment(points, 10)
    assert (best.first, best.stop) == (60, 70) or (best.first, best.stop) == (59, 69)
    assert best.pose == best.stop - 1  # the highest
    # 0.9 m in 9 steps of one of 26 points
    assert best.speed == pytest.approx(0.1 * 30.0 / len(POINTS))


def test_walking_away_is_no_movement_of_the_body() -> None:
    points = standing(50)
    points[:30] += np.linspace(0.0, 9.0, 30)[:, None, None] * [1.0, 0.0, 0.0]
    points[30:] += [9.0, 0.0, 0.0]
    points[40:43, HAND, 2] += [0.2, 0.4, 0.2]
    best = best_moment(points, 8)
    assert best.first <= 40 < best.stop


@pytest.mark.parametrize("n_frames", [1, 2, 5])
def test_a_short_motion_is_its_own_best_part(n_frames: int) -> None:
    best = best_moment(standing(n_frames), 60)
    assert (best.first, best.stop, best.speed) == (0, n_frames, 0.0)


def test_a_thumbnail_shows_the_kick_and_not_the_rest_before_it(client: TestClient) -> None:
    data = client.get("/api/thumbs", params={"name": ["boris/long_fight_1", "nobody"]}).content
    fight, nobody = read_tracks(data)
    assert len(nobody.points) == 0
    assert fight.start > 0.0
    assert len(fight.points) / fight.fps == pytest.approx(2.0, abs=0.1)
    assert fight.moment is not None
    assert fight.start <= fight.moment <= fight.start + 2.0


def test_the_wall_holds_captures_that_differ(client: TestClient) -> None:
    tiles = get(client, "/api/wall", count=20)["tiles"]
    names = [tile["capture"] for tile in tiles]
    assert len(set(names)) == 20
    assert names == sorted(names)
    for tile in tiles:
        assert 0.0 <= tile["start"] < tile["end"] <= tile["duration"] + 0.05
        assert tile["words"]
    said = {word for tile in tiles for word in tile["words"].lower().split()}
    assert any(word.startswith("kick") for word in said)


def test_the_wall_of_a_small_or_empty_database(serve: Serve, tmp_path: Path, some: Path) -> None:
    assert get(serve(tmp_path / "empty.duckdb"), "/api/wall") == {"tiles": []}
    with motiondb.open(tmp_path / "few.duckdb") as db:
        db.add(some)
        n_captures = len(db.captures())
    assert len(get(serve(tmp_path / "few.duckdb"), "/api/wall")["tiles"]) == n_captures


def test_a_poster_is_the_pose_of_the_found_moment(client: TestClient) -> None:
    for match in get(client, "/api/search", q="kick", limit=3)["matches"]:
        (track,) = read_tracks(base64.b64decode(match["poster"]))
        assert track.points.shape == (1, len(POINTS), 3)
        feet = track.points[0, [POINTS.index("l_toe_end"), POINTS.index("r_toe_end")], 1]
        assert feet.max() > 0.3  # metres: a foot is up


def test_an_example_is_not_among_its_answers(client: TestClient) -> None:
    ref = "capture:fatou/long_6"
    part = {"start": 7.0, "end": 11.0}
    others = get(client, "/api/like", ref=ref, limit=5, **part)["matches"]
    assert [match["rank"] for match in others] == [1, 2, 3, 4, 5]
    for match in others:
        shared = min(match["end"], 11.0) - max(match["start"], 7.0)
        apart = match["capture"] != "fatou/long_6"
        assert apart or shared <= 0.5 * (match["end"] - match["start"])
