"""What ``quality`` finds of faults that are planted into real captures; writes a table.

    python benchmarks/capture_quality.py --data DIR [--output docs/measured/capture-quality.md]

DIR holds ``cmu/`` and ``cmu-captions.tsv``, and may hold ``bandai/`` and ``lab/``. Faults are
planted into the joints of 60 captures, every capture with each of them, at the rate of its file and
at 30 a second. Thresholds were chosen on the performers in ``DEVELOPMENT``; the others are the
test. Captures that need something are told by words of their captions (``NEEDING``).

The numbers of ``KEPT_WITH`` (``motiondb/quality/assess.py``) come from the same faults in the
development captures: seconds with a planted fault against seconds of the captures as they are, as
many of the one as of the other.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.body import body
from motiondb.body.joint_names import joint_map
from motiondb.body.retarget import keypoints_of
from motiondb.errors import MotionDBError
from motiondb.files.formats import read_capture
from motiondb.quality.assess import assess, flights, speed_of
from motiondb.quality.measured import measure
from motiondb.records import FAULT, FILE, NEEDS, FloatArray, Quality

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


def spike(metres: float) -> Plant:
    """A joint is elsewhere in one frame."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        name = f"{rng.choice(['l', 'r'])}_{rng.choice(['elbow', 'wrist', 'knee', 'ankle'])}"
        p[_place(len(p), fps, 1.0 / fps, rng), I[name]] += metres * _direction(rng)
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


def names_swapped(p: FloatArray, fps: float, _rng: np.random.Generator) -> tuple[FloatArray, float]:
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


def t_pose(p: FloatArray, fps: float, _rng: np.random.Generator) -> tuple[FloatArray, float]:
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


def slides(speed: float, seconds: float | None = None) -> Plant:
    """The body drifts along the ground, for some time or throughout."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        drift = speed * np.array([np.cos(angle), 0.0, np.sin(angle)])
        moves = np.full(len(p), seconds is None)
        if seconds is not None:
            moves[_place(len(p), fps, seconds, rng)] = True
        return p + np.cumsum(moves)[:, None, None] / fps * drift, fps

    return plant


def foot_sinks(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """A foot is 6 cm lower for two seconds, with half of it the knee."""
    at, side = _place(len(p), fps, 2.0, rng), rng.choice(["l", "r"])
    for joint, share in (("ankle", 1.0), ("toe", 1.0), ("knee", 0.5)):
        p[at, I[f"{side}_{joint}"], 1] -= 0.06 * share
    return p, fps


def body_sinks(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The body is 10 cm lower for two seconds, or for 0.4 of the take."""
    seconds = min(2.0, 0.4 * len(p) / fps)
    return lifted(-0.1, seconds)(p, fps, rng)


def turns_at_once(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The body goes on 45 degrees from where it looked."""
    start = _place(len(p), fps, 0.1, rng).start
    around = p[start, 0] * np.array([1.0, 0.0, 1.0])
    c = np.sqrt(0.5)
    p[start:] = (p[start:] - around) @ np.array([[c, 0, -c], [0, 1, 0], [c, 0, c]]) + around
    return p, fps


def thrown(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The body goes 30 cm aside within 0.1 s."""
    start = _place(len(p), fps, 0.1, rng).start
    share = np.clip((np.arange(len(p)) - start + 1) / (0.1 * fps), 0.0, 1.0)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return p + share[:, None, None] * 0.3 * np.array([np.cos(angle), 0.0, np.sin(angle)]), fps


def trunk_jumps(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """Head, neck, chest, shoulder or toe go 20 cm away and back, each within 0.05 s."""
    joint = str(rng.choice(["head", "neck", "chest", "l_shoulder", "r_toe"]))
    at = np.zeros(len(p))
    at[_place(len(p), fps, 0.15, rng)] = 1.0
    width = max(1, round(0.05 * fps))
    p[:, I[joint]] += (
        0.2 * np.convolve(at, np.ones(width) / width, "same")[:, None] * _direction(rng)
    )
    return p, fps


def trembles(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """One joint trembles by 10 mm for two seconds."""
    at, name = _place(len(p), fps, 2.0, rng), str(rng.choice(["l_wrist", "r_knee", "head"]))
    p[at, I[name]] += rng.normal(scale=0.01, size=p[at, 0].shape)
    return p, fps


def arms_swapped(p: FloatArray, fps: float, _rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The names of the left and right arm are exchanged."""
    return _swap(p, slice(0, len(p)), ("collar", "shoulder", "elbow", "wrist")), fps


def knee_backwards(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """A knee is mirrored through the line from hip to ankle."""
    side = rng.choice(["l", "r"])
    hip, knee, ankle = (I[f"{side}_{j}"] for j in ("hip", "knee", "ankle"))
    line = p[:, ankle] - p[:, hip]
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    bone = p[:, knee] - p[:, hip]
    p[:, knee] += 2.0 * ((bone * line).sum(axis=1, keepdims=True) * line - bone)
    return p, fps


def faces_back(p: FloatArray, fps: float, _rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The body faces backwards on its way, as a robot whose quaternions are misread."""
    return (p - p[:, :1]) * np.array([-1.0, 1.0, -1.0]) + p[:, :1], fps


def hips_swapped(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The hips change sides for 0.3 s."""
    return _swap(p, _place(len(p), fps, 0.3, rng), ("hip",)), fps


def exchanged(a: str, b: str) -> Plant:
    """Two joints of one side change places for half a second."""

    def plant(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
        at, side = _place(len(p), fps, 0.5, rng), rng.choice(["l", "r"])
        pair = [I[f"{side}_{a}"], I[f"{side}_{b}"]]
        p[at, pair[0]], p[at, pair[1]] = p[at, pair[1]].copy(), p[at, pair[0]].copy()
        return p, fps

    return plant


def hand_stays(p: FloatArray, fps: float, rng: np.random.Generator) -> tuple[FloatArray, float]:
    """A wrist stays where it is for a second."""
    at, wrist = _place(len(p), fps, 1.0, rng), I[f"{rng.choice(['l', 'r'])}_wrist"]
    p[at, wrist] = p[at.start, wrist]
    return p, fps


def treadmill(p: FloatArray, fps: float, _rng: np.random.Generator) -> tuple[FloatArray, float]:
    """The mean way is taken away."""
    way = (p[-1, 0] - p[0, 0]) * np.array([1.0, 0.0, 1.0])
    return p - np.linspace(0.0, 1.0, len(p))[:, None, None] * way, fps


def unit(factor: float) -> Plant:
    """All lengths are wrong."""
    return lambda p, fps, _rng: (p * factor, fps)


def rate(factor: float) -> Plant:
    """The file says another rate."""
    return lambda p, fps, _rng: (p, fps * factor)


AFLOAT = ("floats", "held", "stands on", "steps", "sits", "leans", "seam")
FAULTS: dict[str, tuple[Plant, tuple[str, ...]]] = {
    "unit x2.54": (unit(2.54), ("unit",)),
    "unit x0.394": (unit(0.3937), ("unit",)),
    "unit x0.0254": (unit(0.0254), ("unit",)),
    "names swapped": (names_swapped, ("names",)),
    "feet swapped 0.5 s": (feet_swapped, ("swapped",)),
    "hips swapped 0.3 s": (hips_swapped, ("swapped",)),
    "knee and ankle exchanged 0.5 s": (exchanged("knee", "ankle"), ("swapped",)),
    "ankle and toe exchanged 0.5 s": (exchanged("ankle", "toe"), ("swapped",)),
    "hand stays 1 s": (hand_stays, ("frozen",)),
    "foot sinks 6 cm, 2 s": (foot_sinks, ("sinks",)),
    "a knee bends backwards": (knee_backwards, ("bends",)),
    "faces backwards on its way": (faces_back, ("slides", "treadmill")),
    "body sinks 10 cm, 2 s": (body_sinks, ("sinks",)),
    "names of arms swapped": (arms_swapped, ("names",)),
    "body turns 45 degrees": (turns_at_once, ("seam",)),
    "body goes 30 cm in 0.1 s": (thrown, ("seam",)),
    "trunk or toe jumps 20 cm in 0.05 s": (trunk_jumps, ("jumps",)),
    "one joint trembles 10 mm, 2 s": (trembles, ("noise",)),
    "seam of 20 cm": (seam, ("seam",)),
    "frozen 0.3 s": (frozen, ("frozen",)),
    "noise 3 mm": (noise(0.003), ("noise",)),
    "noise 10 mm": (noise(0.010), ("noise",)),
    "T-pose before the take": (t_pose, ("rest pose",)),
    "wrist jumps 20 cm": (jump("wrist", 0.2), ("jumps",)),
    "ankle jumps 20 cm": (jump("ankle", 0.2), ("jumps",)),
    "one joint, one frame, 10 cm": (spike(0.1), ("jumps",)),
    "forearm turns, wrist 20 cm": (turn("wrist", "elbow", 0.2), ("jumps",)),
    "shin turns, ankle 20 cm": (turn("ankle", "knee", 0.2), ("jumps",)),
    "treadmill": (treadmill, ("treadmill",)),
    "floats 10 cm, 1 s": (lifted(0.1, 1.0), AFLOAT),
    "floats 8 cm, 1.5 s": (lifted(0.08, 1.5), AFLOAT),
    "floats 10 cm": (lifted(0.1, None), ("off the floor",)),
    "slides 0.2 m/s": (slides(0.2), ("slides",)),
    "slides 0.2 m/s for 2 s": (slides(0.2, 2.0), ("slides",)),
    "slides 0.1 m/s": (slides(0.1), ("slides",)),
    "rate x0.5, one take": (rate(0.5), ("rate",)),
    "rate x2, one take": (rate(2.0), ("rate",)),
}

UNTOLD = (
    "slides 0.1 m/s",
    "rate x0.5, one take",
    "rate x2, one take",
    "faces backwards on its way",
)
"""Faults that cannot be told, or only of who walks: the numbers of seconds do not rest on them."""


def thinned(take: Take, fps: float | None) -> tuple[FloatArray, float]:
    """A copy of the joints at about a rate, or as they are."""
    step = 1 if fps is None else max(1, round(take.fps / fps))
    return take.points[::step].copy(), take.fps / step


def look(take: Take, points: FloatArray, fps: float) -> Quality:
    """What is said about joints of a capture."""
    return assess(points, fps, take.has_toes)


def clean_takes(takes: list[Take]) -> list[Take]:
    """60 captures of 1.5 to 20 s that need nothing, half of them of the development."""
    out = []
    for tested in (False, True):
        some = [
            t
            for t in takes
            if t.name.startswith("cmu") and not t.needs and t.is_tested == tested
            if 1.5 < len(t.points) / t.fps < 20.0
        ]
        out += some[:: max(1, len(some) // 30)][:30]
    return out


def _is_new(before: Quality, after: Quality, wanted: tuple[str, ...]) -> bool:
    """Whether something wanted is said that was not said before."""
    said = {(f.kind, f.part, round(f.measure, 2)) for f in before.findings}
    return any(
        f.kind in wanted and (f.kind, f.part, round(f.measure, 2)) not in said
        for f in after.findings
    )


def planted(takes: list[Take], fps: float | None) -> list[list[str]]:
    """Rows of the table of faults: recall of development and test, and alarms before."""
    before = [look(t, *thinned(t, fps)) for t in takes]
    rows = []
    for name, (plant, wanted) in FAULTS.items():
        cells = []
        for tested in (False, True):
            hits, alarms, n = 0, 0, 0
            for seed, (take, said) in enumerate(zip(takes, before)):
                if take.is_tested != tested:
                    continue
                points, rate_ = thinned(take, fps)
                way = np.linalg.norm((points[-1, 0] - points[0, 0])[[0, 2]])
                if (
                    name in ("treadmill", "faces backwards on its way")
                    and way / (len(points) / rate_) < 0.7
                ):
                    continue
                changed = plant(points, rate_, np.random.default_rng(seed))
                hits += _is_new(said, look(take, *changed), wanted)
                alarms += any(f.kind in wanted for f in said.findings)
                n += 1
            cells += [f"{hits / n:.2f} of {n}", str(alarms)]
        rows.append([name, *cells])
    return rows


def faulty_seconds(
    name: str, before: FloatArray, after: FloatArray, fps: float, same_rate: bool, n: int
) -> list[bool]:
    """Which of n seconds a fault is in."""
    if len(after) > len(before):
        return [s < 0.5 for s in range(n)]
    if name.startswith(("unit", "rate", "names", "a knee", "faces")) or not same_rate:
        return [True] * n
    changed = np.abs(after - before).max(axis=(1, 2)) > 1e-4
    if name.startswith("seam"):
        changed = np.diff(changed, prepend=False)
    return [bool(changed[int(s * fps) : int((s + 1) * fps)].any()) for s in range(n)]


def calibrated(takes: list[Take]) -> dict[str, tuple[float, float, float]]:
    """For each kind: the probability that its second is clean, and the shares that it rests on."""
    counts: dict[str, list[float]] = {}
    n_clean, n_faulty = 0, 0

    def note(said: Quality, second: int, weight_of: int) -> None:
        kinds = {
            f.kind
            for f in said.findings
            if f.family in (FAULT, FILE) and f.start < second + 1 and f.end > second
        }
        for kind in kinds or {""}:
            counts.setdefault(kind, [0.0, 0.0])[weight_of] += 1.0

    for seed, take in enumerate(takes):
        said = look(take, *thinned(take, None))
        for second in range(len(said.seconds)):
            note(said, second, 0)
            n_clean += 1
        for name, (plant, _) in FAULTS.items():
            if name in UNTOLD:
                continue
            points, fps = thinned(take, None)
            after, rate_ = plant(points.copy(), fps, np.random.default_rng(seed))
            said = look(take, after, rate_)
            n = len(said.seconds)
            for second, bad in enumerate(faulty_seconds(name, points, after, fps, rate_ == fps, n)):
                if bad:
                    note(said, second, 1)
                    n_faulty += 1
    out = {}
    for kind, (clean, faulty) in sorted(counts.items()):
        shares = (clean + 0.5) / n_clean, (faulty + 0.5) / n_faulty
        out[kind] = shares[0] / sum(shares), *shares
    return out


def folder_rates(takes: list[Take]) -> list[list[str]]:
    """Speeds of performers' captures that play at false rates: right, silent and wrong calls."""
    rows = []
    for factor in (0.25, 0.5, 1.0, 2.0, 3.0):
        flown: dict[str, list[tuple[float, float]]] = {}
        for take in takes:
            m = measure(take.points, take.fps * factor)
            flown.setdefault(take.performer, []).extend(flights(m) if m else ())
        speeds = [speed_of(rows_) for rows_ in flown.values()]
        told = [each[0] / factor for each in speeds if each is not None]
        right = sum(abs(np.log(ratio)) < np.log(1.1) for ratio in told)
        wrong = sum(abs(np.log(ratio)) > np.log(1.25) for ratio in told)
        worst = max((abs(ratio - 1.0) for ratio in told), default=0.0)
        silent = len(speeds) - len(told)
        rows.append([f"{factor:g}", str(right), str(wrong), str(silent), f"{worst:.0%}"])
    return rows


def supported(takes: list[Take]) -> list[list[str]]:
    """Captures that need something, and others: how many are said to."""
    rows = []
    for label, some in (
        ("development", [t for t in takes if t.name.startswith("cmu") and not t.is_tested]),
        ("test", [t for t in takes if t.name.startswith("cmu") and t.is_tested]),
        ("Bandai, 30 a second", [t for t in takes if t.name.startswith("bandai")]),
        ("gait of children and Xsens", [t for t in takes if t.name.startswith("lab")]),
    ):
        said = {
            t.name: any(f.family == NEEDS for f in look(t, t.points, t.fps).findings) for t in some
        }
        needing = [t.name for t in some if t.needs]
        alarms = sorted(n for n, yes in said.items() if yes and n not in needing)
        found = sum(said[name] for name in needing)
        rows.append(
            [
                label,
                f"{found} of {len(needing)}",
                f"{len(alarms)} of {len(some) - len(needing)}",
                ", ".join(alarms) or "-",
            ]
        )
    return rows


def thrown_out(takes: list[Take]) -> list[str]:
    """Captures without needs whose mean number is below one half."""
    return [
        t.name
        for t in takes
        if t.name.startswith("cmu")
        and not t.needs
        and look(t, t.points, t.fps).seconds.mean() < 0.5
    ]


def table(heads: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def main() -> None:
    """Measure, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--output", type=Path, default=Path("docs/measured/capture-quality.md"))
    asked = parser.parse_args()
    takes = read_takes(asked.data)
    seconds = sum(len(t.points) / t.fps for t in takes)
    began = time.process_time()
    for take in takes:
        look(take, take.points, take.fps)
    cost = 1000.0 * (time.process_time() - began) / seconds
    clean = clean_takes(takes)
    kinds, seen = (calibrated([t for t in clean if t.is_tested == half]) for half in (False, True))
    cells = [
        [k or "none", f"{p:.2f}", f"{a:.4f}", f"{b:.4f}", f"{seen[k][0]:.2f}" if k in seen else "-"]
        for k, (p, a, b) in kinds.items()
    ]
    out = thrown_out(takes)
    n_sound = sum(t.name.startswith("cmu") and not t.needs for t in takes)
    heads = ["fault", "development: found", "alarms before", "test: found", "alarms before"]
    text = f"""# What quality finds

Written by `python benchmarks/capture_quality.py --data DIR` on {len(takes)} captures,
{seconds:.0f} s. Measuring takes {cost:.1f} ms of processor time for a second of motion, without
reading the file. Performers {", ".join(sorted(DEVELOPMENT))} of the CMU database were looked at
when thresholds were chosen; the others are the test. It is not wholly unseen: which of its planted
faults were missed was looked at once before three rules were changed (where in a stance its drift
is taken, from which height a body floats, jumps there and back), and of other sinking feet before
that of the floor was. Sinks of two seconds are most of some takes: then the lower height is taken
for the floor, if neither is height 0 of the file.

## Things that were not captured

Captures whose captions name something ({", ".join(NEEDING)}), and
others that are said to need something. Captions are a weak key: a dancer who is held by a partner
counts as an alarm.

{table(["captures", "found", "alarms", "which"], supported(takes))}
## Planted faults, at the rate of the files

Found: something of the right kind is said that was not said before. Alarms before: captures of
which that kind is said without the fault; the CMU captures have faults of their own.

{table(heads, planted(clean, None))}
## Planted faults, at 30 frames a second

{table(heads, planted(clean, 30.0))}
## Rates of performers

All captures of a performer play at a false rate. Right: the speed is named within 10 %; wrong: by
more than 25 %; silent: fewer than three jumps agree.

{table(["played at", "right", "wrong", "silent", "worst"], folder_rates(takes))}
## The number of a second

The probability that a second with a finding is one without a planted fault, where seconds with and
without are equally many: shares of seconds of the development captures that have the finding, but
for faults that cannot be told ({"; ".join(UNTOLD)}).
A second has the smallest number of its findings. **It is calibrated on planted faults, not on what
people keep**: no person has judged a second.

{table(["finding", "number", "of clean seconds", "of faulty seconds", "number on the test"], cells)}
Of {n_sound} captures of the CMU database that need nothing, {len(out)} have a mean below 0.5:
{", ".join(out) or "none"}.
"""
    asked.output.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
