"""What the rules need of one capture, in metres of the world and at the capture's own rate.

The canonical body is scaled to legs of 0.85 m and has 30 frames a second: units vanish on it, and a
flight of a run has four frames. So the 21 joints are taken where the file has them, every n-th
frame, so that about 60 remain in a second. Lengths that belong to the body (the thickness of a
foot) are scaled by k = leg / 0.85 m; accelerations and jumps are not.

The floor decides everything else. It is the lowest height at which feet rest for 0.2 s in all and
for a tenth of the time of the most usual height: the 5th percentile of the feet is wrong on
ladders, and the lowest rest is wrong where one bad second has a pointed toe. Rests of feet that
have sunk do not count: nobody steps down through what both feet stood on.

Masses of the segments and their centres: D. Winter, Biomechanics and Motor Control of Human
Movement, 4th edition, table 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from motiondb.body import body
from motiondb.body.features import runs
from motiondb.body.retarget import legs_of
from motiondb.records import BoolArray, FloatArray

MOST_FPS, LEAST_FRAMES = 60.0, 8
I = body.INDEX  # noqa: E741
_SEGMENTS = (
    (0.081, "neck", "head", 1.0),
    (0.497, "pelvis", "neck", 0.5),
    *(
        (mass, f"{side}_{a}", f"{side}_{b}", share)
        for side in "lr"
        for mass, a, b, share in (
            (0.028, "shoulder", "elbow", 0.436),
            (0.022, "elbow", "wrist", 0.68),
            (0.100, "hip", "knee", 0.433),
            (0.0465, "knee", "ankle", 0.433),
            (0.0145, "ankle", "toe", 0.5),
        )
    ),
)  # Share of the mass, from, to, place of its centre
_THICK = {
    "toe": 0.02,
    "tip": 0.01,
    "ankle": 0.08,
    "knee": 0.06,
    "hip": 0.10,
    "shoulder": 0.08,
    "elbow": 0.04,
    "wrist": 0.04,
    "hand": 0.03,
}
PARTS: tuple[str, ...] = (*(f"{s}_{name}" for name in _THICK for s in "lr"), "chest", "head")
"""Places of the body that may touch something; the tip of the foot and the hand are beyond the last
joint."""
P = {name: number for number, name in enumerate(PARTS)}
_BELOW: FloatArray = np.array([*(t for t in _THICK.values() for _ in "lr"), 0.12, 0.10])
"""From the joint to the skin below it, metres on a leg of 0.85 m."""
FEET = [P[f"{s}_{name}"] for s in "lr" for name in ("toe", "tip", "ankle")]
SOLES = [P[f"{s}_{name}"] for s in "lr" for name in ("toe", "ankle")]
_TIP, _HAND = 0.06, 0.35
"""Tip of the foot beyond the toe joint (metres), hand beyond the wrist (by the forearm)."""
_SPIKE: FloatArray = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0
_SPIKE_SHARE = 0.95
REST_SPEED = 0.25  # Metres per second below which a part rests, on a leg of 0.85 m
_REST_SECONDS, _REST_SHARE, _REST_HIGH = 0.2, 0.1, 0.04
_STILL, _STILL_SECONDS = 0.15, 0.08
_MOVE_SECONDS, _IN_PLACE = 0.6, 0.07  # A foot that goes up or down in place
_SUNK, _LEVEL = (0.045, 0.25), 0.03  # Metres by which a foot sinks; heights that are one level


@dataclass(frozen=True, eq=False)
class Measured:
    """Joints of a capture and what follows from them."""

    points: FloatArray  # (frames, 21, 3), metres, y up, without gaps
    fps: float
    missing: BoolArray  # (frames,): some joint has no place
    leg: float  # Hip to ankle, metres
    has_toes: bool  # Whether the file has toes; others are estimated from the shin
    spikes: FloatArray  # (frames, 21): how far a joint is off in one frame of the file, m

    @property
    def k(self) -> float:
        """Size of the body, 1 for a leg of 0.85 m."""
        return self.leg / body.LEG_LENGTH

    @property
    def n(self) -> int:
        """Number of frames."""
        return len(self.points)

    def at(self, joint: str) -> FloatArray:
        """Places of a joint, (frames, 3)."""
        return self.points[:, I[joint]]

    @cached_property
    def x(self) -> FloatArray:
        """Places of the parts (frames, parts, 3)."""
        places = {
            f"{s}_{n}": self.at(f"{s}_{n}")
            for n in _THICK
            if n not in ("tip", "hand")
            for s in "lr"
        }
        for s in "lr":
            toe, ankle = self.at(f"{s}_toe"), self.at(f"{s}_ankle")
            ahead = toe - ankle
            length = np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-6)
            places[f"{s}_tip"] = toe + _TIP * self.k * ahead / length
            wrist = self.at(f"{s}_wrist")
            places[f"{s}_hand"] = wrist + _HAND * (wrist - self.at(f"{s}_elbow"))
        places |= {"chest": self.at("chest"), "head": self.at("head")}
        return np.stack([places[name] for name in PARTS], axis=1)

    @cached_property
    def v(self) -> FloatArray:
        """Velocities of the parts (frames, parts, 3), m/s."""
        flat = self.x.reshape(self.n, -1)
        return smoothed(flat, self.fps, 0.10, (1,))[0].reshape(self.x.shape)

    @cached_property
    def speed(self) -> FloatArray:
        """Speeds of the parts (frames, parts), m/s."""
        return np.sqrt(np.einsum("fpc,fpc->fp", self.v, self.v))

    @cached_property
    def rests(self) -> BoolArray:
        """Whether a part rests (frames, parts)."""
        return self.speed < REST_SPEED * self.k

    @cached_property
    def bottom(self) -> FloatArray:
        """Height of the skin under each part (frames, parts), m."""
        return self.x[..., 1] - _BELOW * self.k

    @cached_property
    def floor(self) -> float:
        """Height of the floor, m."""
        soles = self.bottom[:, SOLES].min(axis=1)
        rest = np.sort(soles[self.rests[:, SOLES].any(axis=1) & ~self.sunk])
        least = _REST_SECONDS * self.fps
        if len(rest) < max(3.0, least):
            return float(np.percentile(soles, 5))
        n = np.searchsorted(rest, rest + _REST_HIGH * self.k) - np.arange(len(rest))
        enough = np.flatnonzero(n >= max(least, _REST_SHARE * n.max()))
        usual = float(np.median(rest[n.argmax() : n.argmax() + n.max()]))
        if abs(usual) < _LEVEL * self.k and 2 * n.max() > len(rest):
            return usual
        first = int(enough[0]) if len(enough) else int(n.argmax())
        densest = first + int(n[first : first + int(n[first])].argmax())
        lowest = float(np.median(rest[densest : densest + int(n[densest])]))
        zero = rest[np.abs(rest) < _LEVEL * self.k]
        few = max(least, _REST_SHARE * n.max()) if lowest < 0.0 else _STILL_SECONDS * self.fps
        off = -_SUNK[1] < lowest / self.k < -_SUNK[0] or lowest > _SUNK[0] * self.k
        if off and len(zero) >= few:
            return float(np.median(zero))  # no floor of a room has a pit
        return lowest

    @cached_property
    def sunk(self) -> BoolArray:
        """Whether a foot stands below the floor that both feet stand on else (frames,).

        Of two such heights the one at height 0 of the file is the floor; if neither is, the one
        at which feet stand for longer.
        """
        feet = [_stances(self, s) for s in "lr"]
        out = np.zeros(self.n, dtype=np.bool_)
        level, at_zero = _LEVEL * self.k, False
        for own, other in (feet, feet[::-1]):
            for low, over in _through_floor(self, own, other) + _lower_alone(self, own, other):
                if abs(low.height) < level:
                    continue
                at_zero |= abs(over) < level
                for stances in own, other:
                    below = [each.height < over - level for each in stances]
                    for a, b in runs(np.array(below, dtype=np.bool_)):
                        if any(each.apart(low) <= 0 for each in stances[a:b]):
                            out[stances[a].start : stances[b - 1].end] = True
        return out if at_zero or 2 * out.sum() < self.n else np.zeros_like(out)

    @cached_property
    def h(self) -> FloatArray:
        """Height of the parts over the floor (frames, parts), m."""
        return self.bottom - self.floor

    @cached_property
    def low(self) -> FloatArray:
        """Height of the lowest part over the floor (frames,), m.

        Tips of feet are estimated: where they lie below the floor while feet rest on it, it is
        taken from where they usually lie.
        """
        low, soles = self.h.min(axis=1), np.abs(self.h[:, SOLES]) < _REST_HIGH * self.k
        down = low[(soles & self.rests[:, SOLES]).any(axis=1)]
        return low - min(0.0, float(np.median(down))) if len(down) else low

    @cached_property
    def com(self) -> FloatArray:
        """Centre of mass (frames, 3), m."""
        total = sum(mass for mass, *_ in _SEGMENTS)
        weights = np.zeros(len(body.JOINTS))
        for mass, start, end, share in _SEGMENTS:
            weights[I[start]] += mass * (1.0 - share) / total
            weights[I[end]] += mass * share / total
        return np.einsum("fjc,j->fc", self.points, weights)

    @cached_property
    def com_fit(self) -> tuple[FloatArray, ...]:
        """Smoothed centre of mass, its velocity and acceleration, each (frames, 3)."""
        return smoothed(self.com, self.fps, 0.16, (0, 1, 2))

    @cached_property
    def pelvis_speed(self) -> FloatArray:
        """Speed of the pelvis (frames,), m/s."""
        return np.linalg.norm(smoothed(self.points[:, 0], self.fps, 0.16, (1,))[0], axis=1)

    @cached_property
    def step_vectors(self) -> FloatArray:
        """What of each frame's step the steps around it do not explain (frames, joints, 3), m."""
        return unexplained(np.diff(self.points, axis=0))

    @cached_property
    def steps(self) -> FloatArray:
        """Length of these (frames, joints), m."""
        v = self.step_vectors
        return np.sqrt(np.einsum("fjc,fjc->fj", v, v))

    @cached_property
    def upright(self) -> FloatArray:
        """Cosine between the trunk and the vertical (frames,)."""
        trunk = self.at("neck") - self.points[:, 0]
        return np.asarray(trunk[:, 1] / np.maximum(np.linalg.norm(trunk, axis=1), 1e-6))

    @cached_property
    def thigh(self) -> FloatArray:
        """Angle of the less raised thigh from hanging straight down (frames,), degrees."""
        angles = []
        for s in "lr":
            bone = self.at(f"{s}_knee") - self.at(f"{s}_hip")
            down = -bone[:, 1] / np.maximum(np.linalg.norm(bone, axis=1), 1e-6)
            angles.append(np.degrees(np.arccos(np.clip(down, -1.0, 1.0))))
        return np.minimum(*angles)


@dataclass(frozen=True)
class _Stance:
    """A time in which a toe is still, on the floor or not."""

    toe: int
    start: int  # Frames
    end: int
    height: float  # Of the skin, m

    def apart(self, other: _Stance) -> int:
        """Frames from one to the other, less than 1 where they meet."""
        return max(self.start - other.end, other.start - self.end)


def _stances(m: Measured, side: str) -> list[_Stance]:
    """Stances of a foot."""
    toe = P[f"{side}_toe"]
    still = long_runs(m.speed[:, toe] < _STILL * m.k, _STILL_SECONDS * m.fps)
    return [_Stance(toe, a, b, float(np.median(m.bottom[a:b, toe]))) for a, b in still]


def _through_floor(
    m: Measured, own: list[_Stance], other: list[_Stance]
) -> list[tuple[_Stance, float]]:
    """Stances that a foot comes to or leaves through the floor, and the height of that.

    It goes down in place from the height at which the other one stands, or up to it. Where a foot
    is only lifted in place, the other one stands below.
    """
    out = []
    for one, next_ in pairwise(own if other else ()):
        low, high = (one, next_) if one.height < next_.height else (next_, one)
        beside = min(other, key=high.apart)
        level = beside.apart(high) < m.fps and abs(beside.height - high.height) < _LEVEL * m.k
        deep = _SUNK[0] * m.k < high.height - low.height < _SUNK[1] * m.k
        if level and deep and next_.start - one.end < _MOVE_SECONDS * m.fps:
            way = m.x[one.end - 1 : next_.start + 1, one.toe][:, [0, 2]]
            if np.linalg.norm(way - way[0], axis=1).max() < _IN_PLACE * m.k:
                out.append((low, high.height))
    return out


def _lower_alone(
    m: Measured, own: list[_Stance], other: list[_Stance]
) -> list[tuple[_Stance, float]]:
    """Stances of a foot around which the other one stands at one height over it, and that height.

    The other one is never so low, and the foot itself stands at that height for longer, if it is
    not height 0 of the file.
    """
    out = []
    for low in own:
        near = [each for each in other if each.apart(low) < m.fps]
        first = min([each.start for each in near], default=m.n)
        last = max([each.end for each in near], default=0)
        if first > max(low.start, 0.3 * m.fps) or last < min(low.end, m.n - 0.3 * m.fps):
            continue
        heights = np.array([each.height for each in near])
        over = float(np.median(heights))
        one_level = np.abs(heights - over).max() < _LEVEL * m.k
        deep = _SUNK[0] * m.k < over - low.height < _SUNK[1] * m.k
        alone = all(each.height - low.height > _SUNK[0] * m.k for each in other)
        if one_level and deep and alone:
            spent = [(each.height - over, each.end - each.start) for each in own]
            at = sum(n for y, n in spent if abs(y) < _LEVEL * m.k)
            below = sum(n for y, n in spent if y < -_LEVEL * m.k)
            if at > below or abs(over) < _LEVEL * m.k:
                out.append((low, over))
    return out


def measure(points: FloatArray, fps: float, has_toes: bool = True) -> Measured | None:
    """Thin a capture to about 60 frames a second and close its gaps; None if too little is there.

    Shapes: `points` (frames, 21, 3), metres, y up, NaN where a joint was not seen.
    """
    step = max(1, round(fps / MOST_FPS))
    kept = np.asarray(points[::step], dtype=np.float64)
    seen = np.asarray(np.isfinite(kept).all(axis=2))
    if len(kept) < LEAST_FRAMES or not seen.any(axis=0).all() or not seen.all(axis=1).any():
        return None
    missing = np.asarray(~seen.all(axis=1))
    if missing.any():
        kept = kept.copy()
        times = np.arange(len(kept))
        for joint in np.flatnonzero(~seen.all(axis=0)):
            known = seen[:, joint]
            for axis in range(3):
                kept[~known, joint, axis] = np.interp(
                    times[~known], times[known], kept[known, joint, axis]
                )
    spikes = np.zeros((step * len(kept), kept.shape[1]))
    for every in {1, step}:  # those of two frames are seen among every second one alone
        thin = points[::every]
        at = every * np.arange(4, len(thin) - 4)
        if len(at):
            spikes[at] = np.maximum(spikes[at], _spikes(thin))
    spikes = spikes.reshape(len(kept), step, -1).max(axis=1)
    return Measured(kept, fps / step, missing, legs_of(kept), has_toes, spikes)


def unexplained(steps: FloatArray) -> FloatArray:
    """Steps (frames - 1, ...) less the middle of the four around each; 0 for the first frame."""
    wide = np.pad(steps, ((2, 2), *((0, 0),) * (steps.ndim - 1)), mode="reflect")
    around = np.stack([wide[:-4], wide[1:-3], wide[3:-1], wide[4:]])
    around.sort(axis=0)
    return np.concatenate([np.zeros_like(steps[:1]), steps - (around[1] + around[2]) / 2.0])


def residual(points: FloatArray, step: int = 1) -> FloatArray:
    """Joints less the cubic through four frames around them (frames, joints, 3), m."""
    n = len(points) - 4 * step
    a, b, c, d, e = (points[i * step : i * step + n] for i in range(5))
    return np.asarray(c - (-a + 4.0 * b + 4.0 * d - e) / 6.0)


def _spikes(points: FloatArray) -> FloatArray:
    """How far joints are off in one frame alone (frames - 8, joints), m; else 0.

    One frame that is off by s leaves residuals of s times `_SPIKE` in the five frames around it.
    Fast motion leaves others, at any rate of frames, so what they share with these is what tells.
    """
    r = residual(points)
    near = np.stack([r[i : len(r) - 4 + i] for i in range(5)])
    norm = _SPIKE @ _SPIKE
    size = np.linalg.norm(np.einsum("k,kfjc->fjc", _SPIKE, near), axis=-1) / norm
    total = np.einsum("kfjc,kfjc->fj", near, near)
    return np.where(norm * size**2 > _SPIKE_SHARE * total, size, 0.0)


def smoothed(
    y: FloatArray, fps: float, seconds: float, orders: tuple[int, ...]
) -> tuple[FloatArray, ...]:
    """Derivatives of y (frames, n) by a sliding quadratic; ends are mirrored through the end."""
    half = max(2, round(seconds * fps / 2.0))
    half = min(half, (len(y) - 1) // 2)
    t = np.arange(-half, half + 1) / fps
    weights = np.linalg.pinv(np.stack([np.ones_like(t), t, t * t / 2.0], axis=1))
    head, tail = 2.0 * y[:1] - y[half:0:-1], 2.0 * y[-1:] - y[-2 : -half - 2 : -1]
    padded = np.concatenate([head, y, tail])
    out = []
    for order in orders:
        total = np.zeros_like(y)
        for number, weight in enumerate(weights[order]):
            total += weight * padded[number : number + len(y)]
        out.append(total)
    return tuple(out)


def long_runs(mask: BoolArray, least: float) -> list[tuple[int, int]]:
    """Intervals of at least so many frames in which a mask is true."""
    return [(a, b) for a, b in runs(mask) if b - a >= least]


def joined(spans: list[tuple[int, int]], gap: float) -> list[tuple[int, int]]:
    """Join intervals that lie at most so many frames apart.

    >>> joined([(0, 3), (4, 6), (20, 22)], 2)
    [(0, 6), (20, 22)]
    """
    out: list[tuple[int, int]] = []
    for a, b in sorted(spans):
        if out and a - out[-1][1] <= gap:
            out[-1] = (out[-1][0], max(b, out[-1][1]))
        else:
            out.append((a, b))
    return out


def times(start: float, end: float) -> str:
    """When something is, in words.

    >>> times(2.94, 8.71), times(0.0, 0.008)
    ('2.9 to 8.7 s', '0.00 to 0.01 s')
    """
    places = 1 if end - start >= 0.1 else 2
    return f"{start:.{places}f} to {end:.{places}f} s"
