"""What ``quality`` finds of faults that are planted into real captures; writes a table.

    python benchmarks/capture_quality.py --data DIR [--output docs/measured/capture-quality.md]

DIR holds ``cmu/`` and ``cmu-captions.tsv``, and may hold ``bandai/`` and ``lab/``. Faults are planted
into the joints of 60 captures, every capture with each of them, at the rate of its file. Thresholds
were chosen on the performers in ``DEVELOPMENT``; the others are the test. Captures that need
something are told by words of their captions (``NEEDING``).
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.body import body
from motiondb.body.joint_names import joint_map
from motiondb.body.retarget import keypoints_of
from motiondb.errors import MotionDBError
from motiondb.files.formats import read_capture
from motiondb.records import FloatArray

DEVELOPMENT = {"01", "05", "07", "14", "16"}
NEEDING = ("climb", "ladder", "sit on", "stool", "hang", "run over", "one step")
I = body.INDEX  # noqa: E741


@dataclass(frozen=True, eq=False)
class Take:
    """A real capture."""

    name: str
    points: FloatArray
    fps: float
    performer: str
    words: str
    has_toes: bool

    @property
    def needs(self) -> bool:
        """Whether its captions name something that was not captured."""
        return self.name.startswith("cmu") and any(w in self.words.lower() for w in NEEDING)

    @property
    def is_tested(self) -> bool:
        """Whether no threshold was chosen with its performer."""
        return self.performer not in DEVELOPMENT


def read_takes(data: Path) -> list[Take]:
    """Read the captures with their captions."""
    rows: dict[str, list[dict[str, str]]] = {}
    with (data / "cmu-captions.tsv").open(encoding="utf-8") as sheet:
        for row in csv.DictReader(sheet, delimiter="\t"):
            rows.setdefault(row["file"], []).append(row)
    takes = []
    for file, said in rows.items():
        first = said[0]
        asf = data / "cmu" / first["skeleton"] if first["skeleton"] else None
        fps = float(first["fps"]) if first["fps"] else None
        words = " | ".join(row["words"] for row in said)
        takes += _read(data / "cmu" / file, data, first["performer"], words, fps, asf)
    for path in sorted(data.glob("bandai/*.bvh")):
        takes += _read(path, data, path.name.split("_")[2], path.stem, None, None)
    for path in sorted([*data.glob("lab/biomechzoo/*/*.c3d"), *data.glob("lab/xsens/walk.bvh")]):
        takes += _read(path, data, path.parent.name, path.stem, None, None)
    return takes


def _read(
    path: Path, data: Path, performer: str, words: str, fps: float | None, asf: Path | None
) -> list[Take]:
    try:
        clip = read_capture(path, fps=fps, skeleton=asf, skip_bad_frames=True)
        roles = joint_map(clip.skeleton, None)
    except MotionDBError:
        return []
    points, _ = keypoints_of(clip, roles)
    toes = {"l_toe", "r_toe"} <= roles.keys()
    return [Take(str(path.relative_to(data)), points, clip.fps, performer, words, toes)]


Plant = Callable[[FloatArray, float, np.random.Generator], tuple[FloatArray, float]]


def _place(n: int, fps: float, seconds: float, rng: np.random.Generator) -> slice:
    """A piece of so many seconds, not at the ends."""
    size = max(1, round(seconds * fps))
    margin = min(round(0.3 * fps), max(0, (n - size) // 3))
    start = int(rng.integers(margin, max(margin + 1, n - size - margin)))
    return slice(start, start + size)


def _direction(rng: np.random.Generator) -> FloatArray:
    u = rng.normal(size=3)
    return np.asarray(u / np.linalg.norm(u))


def jump(joint: str, metres: float) -> Plant:
    """A joint is elsewhere for 0.1 s."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        p[_place(len(p), fps, 0.1, rng), I[f"{rng.choice(['l', 'r'])}_{joint}"]] += (
            metres * _direction(rng)
        )
        return p, fps

    return plant


def turn(joint: str, parent: str, metres: float) -> Plant:
    """A limb is turned about its parent for 0.1 s, so that its end is elsewhere."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        at, s = _place(len(p), fps, 0.1, rng), rng.choice(["l", "r"])
        bone = p[at, I[f"{s}_{joint}"]] - p[at, I[f"{s}_{parent}"]]
        length = np.linalg.norm(bone, axis=1, keepdims=True)
        aside = np.cross(bone, _direction(rng))
        aside *= length / np.linalg.norm(aside, axis=1, keepdims=True)
        angle = 2.0 * np.arcsin(np.minimum(1.0, metres / 2.0 / length))
        turned = np.cos(angle) * bone + np.sin(angle) * aside
        move = turned - bone
        p[at, I[f"{s}_{joint}"]] += move
        if joint == "ankle":
            p[at, I[f"{s}_toe"]] += move
        return p, fps

    return plant


def seam(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The body goes on 20 cm from where it was."""
    p[_place(len(p), fps, 0.1, rng).start :] += 0.2 * _direction(rng)
    return p, fps


def _swap(p: FloatArray, at: slice, names: tuple[str, ...]) -> FloatArray:
    left, right = ([I[f"{s}_{name}"] for name in names] for s in "lr")
    p[at, left], p[at, right] = p[at, right].copy(), p[at, left].copy()
    return p


def feet_swapped(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """Ankles and toes change sides for half a second."""
    return _swap(p, _place(len(p), fps, 0.5, rng), ("ankle", "toe")), fps


def names_swapped(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """All names of left and right are exchanged."""
    return p[:, body.MIRROR], fps


def frozen(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """Nothing moves for 0.3 s."""
    at = _place(len(p), fps, 0.3, rng)
    p[at] = p[at.start]
    return p, fps


def noise(metres: float) -> Plant:
    """Every joint trembles."""
    return lambda p, fps, rng: (p + rng.normal(scale=metres, size=p.shape), fps)


def t_pose(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """Half a second of T-pose comes before the take."""
    rest = np.zeros((len(body.JOINTS), 3))
    for joint, parent in enumerate(body.PARENTS):
        if parent >= 0:
            rest[joint] = rest[parent] + body.OFFSETS[joint]
    scale = np.linalg.norm(p[0, I["l_hip"]] - p[0, I["l_knee"]]) / 0.43
    rest = rest * scale + p[0, 0] * np.array([1.0, 0.0, 1.0]) + np.array([0.0, 0.93 * scale, 0.0])
    return np.concatenate([np.tile(rest, (round(0.5 * fps), 1, 1)), p]), fps


def lifted(metres: float, seconds: float | None) -> Plant:
    """The body is higher, for some time or throughout."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        if seconds is None:
            p[..., 1] += metres
            return p, fps
        at = _place(len(p), fps, seconds, rng)
        ramp = np.zeros(len(p))
        ramp[at] = 1.0
        width = max(1, round(0.1 * fps))
        ramp = np.convolve(ramp, np.ones(width) / width, "same")
        p[..., 1] += metres * ramp[:, None]
        return p, fps

    return plant


def slides(speed: float) -> Plant:
    """The body drifts along the ground."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        drift = speed * np.array([np.cos(angle), 0.0, np.sin(angle)])
        return p + np.arange(len(p))[:, None, None] / fps * drift, fps

    return plant


def treadmill(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The mean way is taken away."""
    way = (p[-1, 0] - p[0, 0]) * np.array([1.0, 0.0, 1.0])
    return p - np.linspace(0.0, 1.0, len(p))[:, None, None] * way, fps


def unit(factor: float) -> Plant:
    """All lengths are wrong."""
    return lambda p, fps, rng: (p * factor, fps)


def rate(factor: float) -> Plant:
    """The file says another rate."""
    return lambda p, fps, rng: (p, fps * factor)


FAULTS: dict[str, tuple[Plant, tuple[str, ...]]] = {
    "unit x2.54": (unit(2.54), ("unit",)),
    "unit x0.394": (unit(0.3937), ("unit",)),
    "unit x0.0254": (unit(0.0254), ("unit",)),
    "names swapped": (names_swapped, ("names",)),
    "feet swapped 0.5 s": (feet_swapped, ("swapped",)),
    "seam of 20 cm": (seam, ("seam",)),
    "frozen 0.3 s": (frozen, ("frozen",)),
    "noise 3 mm": (noise(0.003), ("noise",)),
    "noise 10 mm": (noise(0.010), ("noise",)),
    "T-pose before the take": (t_pose, ("rest pose",)),
    "wrist jumps 20 cm": (jump("wrist", 0.2), ("jumps",)),
    "ankle jumps 20 cm": (jump("ankle", 0.2), ("jumps",)),
    "forearm turns, wrist 20 cm": (turn("wrist", "elbow", 0.2), ("jumps",)),
    "shin turns, ankle 20 cm": (turn("ankle", "knee", 0.2), ("jumps",)),
    "treadmill": (treadmill, ("treadmill",)),
    "floats 10 cm, 1 s": (
        lifted(0.1, 1.0),
        ("floats", "held", "stands on", "steps", "sits", "leans", "seam"),
    ),
    "floats 10 cm": (lifted(0.1, None), ("off the floor",)),
    "slides 0.2 m/s": (slides(0.2), ("slides",)),
    "slides 0.1 m/s": (slides(0.1), ("slides",)),
    "rate x0.5, one take": (rate(0.5), ("rate",)),
    "rate x2, one take": (rate(2.0), ("rate",)),
}
