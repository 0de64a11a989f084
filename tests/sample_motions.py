"""The captures that motiondb made itself, by name, for tests that ask no database."""

from __future__ import annotations

from pathlib import Path

from motiondb.body import retarget
from motiondb.files.formats import read_capture
from motiondb.records import Clip, Motion

SAMPLES = Path(__file__).resolve().parents[1] / "sample_data"


def sample_clip(name: str) -> Clip:
    """A capture as its file has it."""
    return read_capture(SAMPLES / "captures" / f"{name}.bvh")


def sample_motion(name: str) -> Motion:
    """The same on the canonical body."""
    return retarget.to_motion(sample_clip(name))
