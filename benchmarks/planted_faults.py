"""Faults that are planted into the joints of real captures, and what names them.

Each changes a copy of the joints and returns them with the rate of the file, by a random place,
joint and direction.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motiondb.body import body
from motiondb.records import FloatArray

I = body.INDEX  # noqa: E741

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
