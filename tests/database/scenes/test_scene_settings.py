"""How a scene is to be made: what is refused, and the temperatures of chains."""

from __future__ import annotations

import pytest

from motiondb.database.scenes.scene_making import SceneSettings
from motiondb.errors import SceneError


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"chains": 0}, "chains: expected 1 to 64"),
        ({"minutes": 0.0}, "minutes: expected a number above 0"),
        ({"minutes": float("nan")}, "minutes: expected a number above 0"),
        ({"rounds": 0}, "rounds: expected at least 1"),
        ({"tries": 0}, "tries: expected at least 1"),
    ],
)
def test_settings_that_make_no_sense(settings: dict, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        SceneSettings(**settings)


def test_more_chains_go_on_in_the_same_ratio() -> None:
    few, many = SceneSettings(chains=2).temperatures, SceneSettings(chains=7).temperatures
    assert few == many[:2]
    assert len(many) == 7
    assert many[6] / many[5] == pytest.approx(many[5] / many[4])
