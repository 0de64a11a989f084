"""The shipped activities beside basketball, on the sample data: small and quick scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.body import body, retarget
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.database.scenes.scenes import Scene, SceneSettings

ACTIVITIES = Path(__file__).resolve().parents[3] / "sample_data" / "activities"
QUICK = SceneSettings(seed=2, rounds=8, chains=2, tries=1)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Scene]:
    folder = tmp_path_factory.mktemp("activities")
    with motiondb.open(folder / "m.duckdb") as db:
        for place, prefix in ((ACTIVITIES.parent, ""), (ACTIVITIES, "activities/")):
            sheets = {"words": place / "captions.tsv", "events": place / "events.tsv"}
            settings = AddSettings(jobs=1, prefix=prefix)
            assert not db.add(place / "captures", settings=settings, **sheets).problems
        names = ("meeting", "sparring", "delivery")
        return {name: db.scenes.make(name, QUICK) for name in names}


def joints(scene: Scene, name: str) -> np.ndarray:
    placed = {player.player: player.motion for player in scene.made.polished.players}
    return retarget.motion_positions(placed[name])[0]


def instants(scene: Scene, name: str) -> dict[str, list[int]]:
    """The frames at which a player's actions have their instants."""
    table, timeline = scene.made.table, scene.made.polished.timeline
    number = table.players.index(name)
    of: dict[str, list[int]] = {}
    for action, frame in zip(table.actions[number], timeline.instants[number], strict=True):
        of.setdefault(action, []).append(int(frame))
    return of


@pytest.mark.slow
def test_people_who_meet_bow_together_and_one_sits_on_the_chair(scenes: dict[str, Scene]) -> None:
    scene = scenes["meeting"]
    anna, ben = instants(scene, "Anna"), instants(scene, "Ben")
    assert abs(anna["bow"][0] - ben["bow"][0]) <= 2
    heads = [joints(scene, name)[:, body.INDEX["head"], 1] for name in ("Anna", "Ben")]
    for head, of in zip(heads, (anna, ben), strict=True):
        assert head[of["bow"][0]] < head.max() - 0.1
    pelvis = joints(scene, "Anna")[-1, 0]
    assert pelvis[1] < 0.7  # she is seated at the end
    assert np.hypot(pelvis[0] - 1.2, pelvis[2] + 2.2) < 0.6
    assert scene.made.polished.ball is None


@pytest.mark.slow
def test_every_blow_is_answered_once_and_in_order(scenes: dict[str, Scene]) -> None:
    scene = scenes["sparring"]
    ruth, bela = instants(scene, "Ruth"), instants(scene, "Bela")
    assert len(ruth["punch"]) == len(bela["parry"]) + len(bela["duck"]) == 2
    for act, answer in (
        (ruth["punch"][0], bela["parry"][0]),
        (ruth["punch"][1], bela["duck"][0]),
        (bela["kick"][0], ruth["parry"][0]),
    ):
        assert abs(act - answer) <= 2
    head = joints(scene, "Bela")[:, body.INDEX["head"], 1]
    low = bela["duck"][0]
    assert abs(int(np.argmin(head[low - 10 : low + 11])) - 10) <= 3  # the instant of the grammar
    assert not [rule for rule in scene.made.report.rules if rule.unmet]


@pytest.mark.slow
def test_a_box_goes_from_the_table_by_two_pairs_of_hands_to_the_shelf(
    scenes: dict[str, Scene],
) -> None:
    scene = scenes["delivery"]
    box = scene.made.polished.ball
    assert box is not None
    np.testing.assert_allclose(box.positions[0], (-3.4, 0.76, 0.0), atol=1e-6)
    np.testing.assert_allclose(box.positions[-1], (3.4, 0.76, 0.4), atol=1e-6)
    held = box.holder[np.r_[True, np.diff(box.holder) != 0]].tolist()
    assert [player for player in held if player >= 0] == [0, 1]
    steps = np.linalg.norm(np.diff(box.positions, axis=0), axis=1)
    assert steps.max() < 0.2  # it never leaps
    assert box.gap[box.holder >= 0].max() < 0.35
