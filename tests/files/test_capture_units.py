"""The length unit, found from the size of the body."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import body
from motiondb.body.world import UNITS, find_unit
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.files.units import unit_from_name
from motiondb.records import Clip, Skeleton


@given(name=st.sampled_from(sorted(UNITS)), leg=st.floats(0.60, 1.03))
def test_every_unit_is_found_for_every_adult(name: str, leg: float) -> None:
    skeleton = body.standard_skeleton(leg / UNITS[name])
    assert find_unit(skeleton) == (UNITS[name], ())


@given(name=st.sampled_from(sorted(UNITS)), scale=st.floats(0.75, 1.2))
def test_bodies_with_strange_names(name: str, scale: float) -> None:
    size = scale / UNITS[name]
    skeleton = Skeleton(
        names=("a", "b", "c"),
        parents=np.array([-1, 0, 1]),
        offsets=np.array([[0, 0, 0], [0.1, 0, 0], [0, -0.5, 0]]) * size,
        end_sites=((2, (0.0, -0.5 * size, 0.0)),),
    )
    assert find_unit(skeleton) == (UNITS[name], ())


def test_joint_positions_count_more_than_offsets() -> None:
    skeleton = body.standard_skeleton(85.0)
    positions = np.tile(skeleton.offsets, (5, 1, 1))
    lost = replace(skeleton, offsets=skeleton.offsets * 1e-3)
    assert find_unit(lost, positions)[0] == 0.01


def test_doubtful_sizes_are_noted() -> None:
    unit, notes = find_unit(body.standard_skeleton(3.0))
    assert unit == 1.0
    assert notes == (
        "The length unit is a guess (1 m): the body would be 3.6 times the usual size. "
        "Give the unit if it matters.",
    )
    unit, notes = find_unit(body.standard_skeleton(51.0))  # a child of 1.05 m in centimetres
    assert unit == UNITS["inch"]
    assert "the body would be 1.6 times the usual size" in notes[0]
    _, notes = find_unit(body.standard_skeleton(42.0))  # one of .86 m
    assert "the body would be 1.3 times the usual size" in notes[0]
    one = Skeleton(names=("a",), parents=np.array([-1]), offsets=np.zeros((1, 3)))
    assert find_unit(one) == (
        1.0,
        ("The skeleton has no size; its unit is taken to be the metre.",),
    )


def test_units_by_name() -> None:
    assert [unit_from_name(name) for name in ("m", "CM", "mm", "in", "inch", "0.3")] == [
        1.0, 0.01, 0.001, 0.0254, 0.0254, 0.3,
    ]  # fmt: skip
    assert unit_from_name("cmu") == pytest.approx(0.056444, abs=1e-6)
    for name in ("furlong", "0", "-1", "nan", "inf"):
        with pytest.raises(CaptureError) as caught:
            unit_from_name(name)
        assert str(caught.value) == (
            f"unit: expected one of m, cmu, inch, cm, mm or a number of metres, found {name!r}. "
            "Give one."
        )


@pytest.mark.parametrize(("unit", "is_told"), [(None, False), (0.01, False), (1.0, True)])
def test_a_unit_that_was_asked_for_and_fits_no_person_is_told(
    tmp_path: Path, unit: float | None, is_told: bool
) -> None:
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (2, 21, 1))
    path = tmp_path / "a.bvh"
    write_bvh(Clip(body.standard_skeleton(), 30.0, turns, np.zeros((2, 3)), unit=0.01), path)
    notes = read_capture(path, unit=unit).notes
    assert notes == (
        ("In the unit that was asked for (1 m) the body is 1e+02 times the usual size.",)
        if is_told
        else ()
    )
