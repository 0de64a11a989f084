"""How a scene is to be made: what is refused."""

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
