"""Warped variants of captures: as many hours of motion as wanted, of which none repeats another.

A variant plays a capture faster or slower with a changing tempo, perhaps mirrored, by a body of
another size that holds its joints a few degrees otherwise and sways slowly. It is further from its
original than a copy may be (``motiondb.search.copies``), but shows the same action, so that the
words of the original hold for it. Variants of one number are by one performer.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.body import retarget, rotation
from motiondb.files.bvh_writer import write_bvh
from motiondb.records import MOTION_FPS, Motion

TEMPO = (0.8, 1.25)  # Smallest and largest mean speed of a variant
TEMPO_CHANGE = 0.12  # Largest share by which the speed changes within a variant
POSTURE = 5.0  # Standard deviation of the constant angle of a joint, degrees
SWAY = 2.0  # Largest angle by which a joint sways, degrees
SWAY_SECONDS = (2.0, 5.0)
SIZE = 0.08  # Standard deviation of the logarithm of the size of the body
COLUMNS = ("file", "performer", "words", "start", "end")


@dataclass(frozen=True)
class Original:
    """A capture to make variants of, with its captions (words, start, end in seconds)."""

    name: str
    motion: Motion
    captions: tuple[tuple[str, float | None, float | None], ...]

    @property
    def seconds(self) -> float:
        """Its duration."""
        return self.motion.n_frames / MOTION_FPS


def read_originals(folder: Path, sheet: Path | None, database: Path) -> list[Original]:
    """The captures below a folder with the words of a sheet, added to a database once."""
    if not database.is_file():
        draft = database.with_name(f"draft-{database.name}")
        draft.unlink(missing_ok=True)
        with motiondb.open(draft) as db:
            db.add(folder, words=sheet)
        draft.rename(database)
    with motiondb.open(database, read_only=True) as db:
        said = {
            info.name: tuple((c.words, c.start, c.end) for c in db.words.captions(info.name))
            for info in db.captures()
        }
        return [Original(name, db.motion(name), rows) for name, rows in said.items()]


def variant(original: Motion, seed: int) -> tuple[Motion, np.ndarray]:
    """A variant of a motion, and the time in the original (frames) of each of its frames."""
    rng = np.random.default_rng(seed)
    motion = retarget.mirror(original) if rng.random() < 0.5 else original
    n = max(2, round(original.n_frames / rng.uniform(*TEMPO)))
    along = np.arange(n) / (n - 1)
    depth, waves = TEMPO_CHANGE * rng.random(), rng.integers(1, 4)
    times = along + depth / (2 * np.pi * waves) * np.sin(2 * np.pi * waves * along)
    times = times * (original.n_frames - 1)
    low = np.minimum(times.astype(np.int64), original.n_frames - 2).clip(0)
    share = (times - low)[:, None, None]
    q = rotation.unroll(motion.local_rotations.astype(np.float64))
    high = np.minimum(low + 1, original.n_frames - 1)
    turned = rotation.normalize(q[low] * (1.0 - share) + q[high] * share)
    root = motion.root_positions.astype(np.float64)
    root = root[low] * (1.0 - share[:, 0]) + root[high] * share[:, 0]
    joints = turned.shape[1]
    posture = np.radians(rng.normal(0.0, POSTURE, (joints, 3)))
    posture[0] = 0.0  # the pelvis: the whole body would lean
    period = rng.uniform(*SWAY_SECONDS, (joints, 3)) * MOTION_FPS
    phase = rng.uniform(0.0, 2 * np.pi, (joints, 3))
    sway = np.radians(SWAY) * np.sin(2 * np.pi * np.arange(n)[:, None, None] / period + phase)
    turned = rotation.multiply(turned, rotation.exp(posture + sway))
    heading = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), rng.uniform(0.0, 2 * np.pi))
    turned[:, 0] = rotation.multiply(heading[None], turned[:, 0])
    made = Motion(
        turned.astype(np.float32),
        rotation.rotate(heading[None], root).astype(np.float32),
        float(original.leg_length * np.exp(rng.normal(0.0, SIZE))),
    )
    return made, times


def make_pool(originals: list[Original], pool: Path, hours: float) -> list[tuple[Path, list]]:
    """Variants of at least some hours below ``pool``; each file with its rows of the sheet."""
    made: list[tuple[Path, list]] = []
    seconds = 0.0
    for number, place in _numbered(len(originals)):
        if seconds >= 3600.0 * hours:
            return made
        original, seed = originals[place], number * len(originals) + place
        name = f"v{number:03d}/{original.name.replace('/', '_')}.bvh"
        path = pool / name
        motion, times = variant(original.motion, seed)
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            draft = path.with_name("draft.bvh")
            write_bvh(retarget.to_clip(motion), draft)
            draft.rename(path)
        said = [_row(name, number, caption, times) for caption in original.captions]
        made.append((path, said))
        seconds += motion.n_frames / MOTION_FPS
    return made


def _numbered(n: int) -> Iterator[tuple[int, int]]:
    """Number of the variant and place of the original, without end."""
    number = 0
    while True:
        yield from ((number, place) for place in range(n))
        number += 1


def _row(name: str, number: int, caption: tuple, times: np.ndarray) -> list:
    """A row of the sheet; the times of a caption are moved with the tempo."""
    words, *limits = caption
    moved = [
        "" if at is None else f"{np.interp(at * MOTION_FPS, times, np.arange(len(times))) / 30:.3f}"
        for at in limits
    ]
    return [name, f"performer{number:03d}", words, *moved]


def lay_out(made: list[tuple[Path, list]], pool: Path, folder: Path) -> tuple[Path, Path]:
    """A folder of links to some variants, and their sheet; both are made anew."""
    captures, sheet = folder / "captures", folder / "captions.tsv"
    for path, _ in made:
        link = captures / path.relative_to(pool)
        link.parent.mkdir(parents=True, exist_ok=True)
        if not link.exists():
            os.link(path, link)
    with sheet.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter="\t")
        writer.writerow(COLUMNS)
        writer.writerows(row for _, rows in made for row in rows)
    return captures, sheet
