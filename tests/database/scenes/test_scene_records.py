"""Records of scenes: their clips are found again among the clips of a database."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motiondb.database.scenes import scene_records
from motiondb.errors import SceneError
from motiondb.scene.clips.clips import ClipSource
from motiondb.store import SceneClip

PLACES = st.tuples(
    st.sampled_from(["a", "b", "c"]), st.integers(0, 3000), st.integers(0, 3000), st.booleans(),
    st.sampled_from([-0.1, 0.0, 0.1]), st.sampled_from([0.9, 1.0]),
)  # fmt: skip


def library(places: list[tuple]) -> SimpleNamespace:
    source = tuple(ClipSource(*place) for place in places)
    return SimpleNamespace(terminals=("run",), of=lambda _: range(len(source)), source=source)


def kept(place: tuple) -> SceneClip:
    capture, *rest = place
    return SceneClip("run", capture, "", *rest)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(places=st.lists(PLACES, min_size=1, max_size=12), wanted=PLACES)
def test_the_most_similar_entry_is_that_of_a_search_through_all(places, wanted):
    clips = library(places)
    clip = kept(wanted)
    costs = [scene_records._unlike(source, clip) for source in clips.source]
    assert scene_records._entry(clips, clip) == int(np.argmin(costs))


def test_an_entry_that_is_there_is_found_itself():
    places = [("a", 0, 30, False, 0.0, 1.0), ("b", 0, 30, False, 0.0, 1.0)]
    assert scene_records._entry(library(places), kept(places[1])) == 1


def test_an_action_without_clips_is_named():
    with pytest.raises(SceneError, match="run: expected clips of this action, found none"):
        scene_records._entry(library([]), kept(("a", 0, 30, False, 0.0, 1.0)))
