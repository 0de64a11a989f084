"""Gait of files and captures by the public verb and the command, with its picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb.body import body
from motiondb.body.retarget import solved_body


def walk(fps: float = 100.0, seconds: float = 5.0, speed: float = 1.2) -> motiondb.Clip:
    """A person who puts one foot before the other every half second, straight ahead."""
    times = np.arange(round(seconds * fps)) / fps
    places = np.zeros((21, 3))
    for joint in range(1, 21):
        places[joint] = places[body.PARENTS[joint]] + body.OFFSETS[joint]
    points = np.tile(np.add(places, [0.0, 0.9, 0.0]), (len(times), 1, 1))
    points[..., 2] += (speed * times)[:, None]
    shares = np.linspace(0.0, 1.0, 1001)
    carried = np.cumsum(np.sin(np.pi * shares) ** 0.25)
    for side, offset in (("l", 0.0), ("r", 0.5)):
        phase = times + offset
        swing = np.clip((phase % 1.0 - 0.6) / 0.4, 0.0, 1.0)
        place = np.floor(phase) + np.interp(swing, shares, carried / carried[-1]) - offset
        hip, knee, ankle, toe = (
            body.INDEX[f"{side}_{name}"] for name in ("hip", "knee", "ankle", "toe")
        )
        points[:, ankle, 2] = speed * place + 0.36
        points[:, ankle, 1] = 0.08 + 0.08 * np.sin(np.pi * swing)
        points[:, toe] = points[:, ankle] + [0.0, -0.06, 0.14]
        points[:, knee] = (points[:, hip] + points[:, ankle]) / 2.0 + [0.0, 0.0, 0.05]
    skeleton, rotations = solved_body(points)
    return motiondb.Clip(skeleton, fps, rotations, points[:, 0], unit=0.01, up="y")


@pytest.fixture
def base(tmp_path: Path) -> motiondb.MotionDB:
    motiondb.write_bvh(walk(), tmp_path / "walk.bvh")
    opened = motiondb.MotionDB(tmp_path / "a.motiondb")
    assert opened.add([tmp_path / "walk.bvh"]).added == ("walk",)
    return opened


def test_a_capture_its_file_and_its_clip_have_the_same_gait(
    base: motiondb.MotionDB, tmp_path: Path
) -> None:
    told = base.captures.gait("walk", png=tmp_path / "gait.png")
    assert (tmp_path / "gait.png").read_bytes()[:4] == b"\x89PNG"
    found = {m.measure: m.both for m in told.measures}
    assert found["cadence"] == pytest.approx(120.0, rel=0.03)
    assert found["speed"] == pytest.approx(1.2, rel=0.03)
    assert found["step length"] == pytest.approx(0.6, rel=0.05)
    assert (told.treadmill, told.notes, told.fps) == (0.0, (), 100.0)
    assert base.captures.gait(tmp_path / "walk.bvh").cycles == told.cycles
    assert base.captures.gait(base.clip("walk")).cycles == told.cycles
    assert len(base.captures.gait("walk", 0.0, 2.0).cycles) < len(told.cycles)
    assert f"{len(told.cycles)} cycles" in repr(told)


def test_the_command_prints_a_table_json_and_rows(
    command: Any, base: motiondb.MotionDB, tmp_path: Path
) -> None:
    base.close()
    ask = ("describe", "walk", "--gait", "--db", tmp_path / "a.motiondb")
    shown = command(*ask)
    assert shown.code == 0, shown.err
    assert "cadence" in shown.out
    said = json.loads(command(*ask, "--json").out)
    assert {event["name"] for event in said["events"]} == {"foot_strike", "foot_off"}
    rows = command(*ask, "--csv", "-").out.splitlines()
    assert rows[0].startswith("side,start,end,foot_off,stance")
    assert len(rows) == 1 + len(said["cycles"])
    assert command("describe", "--gait", "--where", "name=walk").code != 0


def test_who_stands_has_no_gait(base: motiondb.MotionDB, tmp_path: Path) -> None:
    clip = walk(speed=0.0)
    told = base.captures.gait(clip)
    assert told.events == ()
    assert told.notes[0].startswith("no gait")
    with pytest.raises(motiondb.QueryError, match="expected steps to draw"):
        base.captures.gait(clip, png=tmp_path / "none.png")
