"""The captures that motiondb made itself, by name."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
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


def copied_samples(
    folder: Path, names: Sequence[str], more: Sequence[str] = ()
) -> tuple[Path, Path]:
    """Copies of some of the sample captures, the sheet of their words, and more without words."""
    for name in (*names, *more):
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(SAMPLES / "captures" / f"{name}.bvh", target)
    rows = (SAMPLES / "captions.tsv").read_text().splitlines()
    kept = [row for row in rows if row.startswith(("file\t", *(f"{name}.bvh" for name in names)))]
    (folder / "words.tsv").write_text("\n".join(kept) + "\n")
    return folder / "captures", folder / "words.tsv"
