"""Are duplicates found? Copies, cuts and mirror images planted among real captures.

Of every chosen capture three are written as new BVH files and read again, as any file is: the
whole take and a cut at arbitrary times, both on the capture's own skeleton with limbs made longer
or shorter, at another frame rate, turned, moved and with noise on every angle; and the mirror image
on the canonical skeleton.

    python benchmarks/duplicates.py --data DIR        # DIR holds cmu/ and cmu-captions.tsv
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb import store
from motiondb.body import retarget, rotation
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.records import Clip, FloatArray, Motion
from motiondb.search import copies

RATES = (24.0, 25.0, 50.0, 60.0, 100.0, 120.0)
"""Frames per second to which a planted copy is resampled: rates that captures commonly have."""
NOISE = 0.2
"""Degrees, on every angle of every frame."""
LIMBS = 0.08
"""Bones become longer or shorter by up to this share."""
SHORTEST = 1.5
"""Seconds; shorter captures are not chosen, shorter cuts not made."""


@dataclass(frozen=True, eq=False)
class Planted:
    """A motion read from a planted file; ``original`` is the number of its capture."""

    original: int
    kind: str
    motion: Motion


def at_times(values: FloatArray, times: FloatArray) -> FloatArray:
    """Values between frames: array (times, ...)."""
    low = np.clip(times.astype(np.int64), 0, len(values) - 2)
    share = (times - low).reshape(-1, *([1] * (values.ndim - 1)))
    return values[low] * (1.0 - share) + values[low + 1] * share


def rewrite(clip: Clip, start: float, end: float, rng: np.random.Generator) -> Clip:
    """A part of a clip (seconds) on another skeleton, at another rate, turned, moved, noisy."""
    fps = float(rng.choice([rate for rate in RATES if abs(rate - clip.fps) > 1]))
    times = np.arange(start, end, 1.0 / fps) * clip.fps
    times = times[times <= clip.n_frames - 1]
    scale = 1.0 + rng.uniform(-LIMBS, LIMBS)
    skeleton = replace(
        clip.skeleton,
        offsets=clip.skeleton.offsets * scale * _limb_scales(clip.skeleton.names, rng)[:, None],
    )
    turns = at_times(rotation.unroll(clip.local_rotations), times)
    angles = rng.normal(0.0, np.deg2rad(NOISE), (*turns.shape[:-1], 3))
    turns = rotation.multiply(rotation.normalize(turns), rotation.exp(angles / 2))
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), rng.uniform(0, 2 * np.pi))
    turns[:, 0] = rotation.multiply(facing, turns[:, 0])
    places = rotation.rotate(facing, at_times(clip.root_positions, times)) * scale + [1.0, 0.0, 2.0]
    return replace(
        clip,
        skeleton=skeleton,
        fps=fps,
        local_rotations=turns,
        root_positions=places,
        joint_positions=None,
        unit=0.01,
    )


def _limb_scales(names: Sequence[str], rng: np.random.Generator) -> FloatArray:
    """A factor for every bone, the same left and right."""
    factor: dict[str, float] = {}
    scales = []
    for name in names:
        plain = name.lower().replace("left", "").replace("right", "")
        plain = plain[1:] if plain[:1] in "lr" and len(plain) > 2 else plain
        scales.append(factor.setdefault(plain, 1.0 + float(rng.uniform(-LIMBS, LIMBS))))
    return np.array(scales)


def plant(number: int, clip: Clip, motion: Motion, rng: np.random.Generator) -> list[Planted]:
    """The three files of one capture, written and read again."""
    length = float(rng.uniform(SHORTEST, max(SHORTEST, 0.6 * clip.duration)))
    start = float(rng.uniform(0.0, clip.duration - length))
    files = {
        "same": rewrite(clip, 0.0, clip.duration, rng),
        "cut": rewrite(clip, start, start + length, rng),
        "mirror": retarget.to_clip(retarget.mirror(motion)),
    }
    planted = []
    with tempfile.TemporaryDirectory() as folder:
        for kind, changed in files.items():
            path = Path(folder) / f"{kind}.bvh"
            write_bvh(changed, path)
            planted.append(Planted(number, kind, retarget.to_motion(read_capture(path))))
    return planted


def report(
    planted: Sequence[Planted],
    n_captures: int,
    copies_found: Sequence[copies.Copy],
    twins: set[tuple[int, int]],
) -> str:
    """The page: recall and precision by kind."""
    made = Counter(p.kind for p in planted)
    hit, right, wrong = Counter[str](), Counter[str](), Counter[str]()
    for number, plan in enumerate(planted, start=n_captures):
        mine = [c for c in copies_found if c.query == number and c.take < n_captures]
        hit[plan.kind] += any(c.take == plan.original and c.kind == plan.kind for c in mine)
        for copy in mine:
            true = copy.take == plan.original or (copy.take, plan.original) in twins
            (right if true else wrong)[plan.kind] += 1
    lines = [
        "# Detection of planted duplicates",
        "",
        "How many planted copies does `list --duplicates` find? Measured by "
        f"`python benchmarks/duplicates.py --data DIR`. {len(planted)} files planted "
        f"among {n_captures} captures of the CMU database: whole takes and cuts on skeletons "
        f"whose bones are up to {LIMBS:.0%} longer or shorter, at another frame rate, turned, "
        f"moved, with {NOISE:g} degrees of noise on every angle; and mirror images on the canonical"
        " skeleton. A relation is right if it leads to the original, or to another copy of the "
        "original.",
        "",
        "| kind | planted | found (recall) | relations | right (precision) |",
        "|---|---|---|---|---|",
    ]
    kinds = [*sorted(made), "all"]
    for counter in (made, hit, right, wrong):
        counter["all"] = sum(counter.values())
    for kind in kinds:
        relations = right[kind] + wrong[kind]
        lines.append(
            f"| {kind} | {made[kind]} | {hit[kind]} ({hit[kind] / made[kind]:.1%}) | {relations} | "
            f"{right[kind]} ({right[kind] / max(relations, 1):.1%}) |"
        )
    lines += [
        "",
        "Not found are copies of people who hardly move (noise changes them more than motion "
        "does), takes whose joints move by more than 1 cm when the bones change, and takes with "
        "spikes. A limit of 1.5 cm would find more, but takes of the sample data that repeat one "
        "phrase would then count as copies.",
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Plant, look, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--db", type=Path, help="a database that holds the captures")
    parser.add_argument("--chosen", type=int, default=100)
    parser.add_argument("--out", type=Path, default=Path("docs/measured/duplicates.md"))
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    planted: list[Planted] = []
    with tempfile.TemporaryDirectory() as folder:
        path = options.db or Path(folder) / "captures.duckdb"
        with motiondb.open(path, read_only=options.db is not None) as db:
            if options.db is None:
                db.add(options.data / "cmu", options.data / "cmu-captions.tsv")
            infos = db.captures()
            motions = [store.load_motion(db.store, info.capture_id) for info in infos]
            fit = [
                n for n, i in enumerate(infos) if i.duration > SHORTEST and i.format != "deepmimic"
            ]
            for n in sorted(rng.permutation(fit)[: options.chosen].tolist()):
                planted += plant(n, db.clip(infos[n].name), motions[n], rng)
    everything = [*motions, *(p.motion for p in planted)]
    library = copies.build_library([copies.copy_poses(motion) for motion in everything])
    matches = copies.find_copies(library, range(len(everything)))
    n = len(motions)
    among = {(c.query, c.take) for c in matches if c.query < n and c.take < n}
    text = report(planted, n, matches, among | {(b, a) for a, b in among})
    options.out.write_text(text, encoding="utf-8")
    print(text)
    for number, plan in enumerate(planted, start=n):
        mine = [c for c in matches if c.query == number and c.take < n]
        if not any(c.take == plan.original and c.kind == plan.kind for c in mine):
            print(f"missed: {plan.kind} of {infos[plan.original].name}")
        for c in mine:
            if c.take != plan.original and (c.take, plan.original) not in among:
                print(f"{plan.kind} of {infos[plan.original].name} found in {infos[c.take].name}")


if __name__ == "__main__":
    main()
