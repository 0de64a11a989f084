"""The score of a take: keys on channels over time, with the truth of what is being done.

An action writes keys (time, value) on channels and says where it begins and ends. Between keys runs
a monotone cubic (PCHIP): flat where two keys agree, so a planted foot stays exactly where it is.
Body and hands are then smoothed a little, wander a little, and go to :mod:`sample_data.rig`.

Distances in actions are in metres on a body with legs of 0.85 m, in the *place frame*: origin
midway between the feet, x to the left, z ahead. Hands are in arm lengths from their shoulder, in
the chest's frame: (outward, up, ahead).
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping

import numpy as np
from scipy.interpolate import PchipInterpolator

from motiondb.body import rotation
from motiondb.records import Clip, FloatArray
from sample_data import rig

from .performers import ROLES, Performer, skeleton

FPS = 30.0
BODY = ("px", "py", "pz", "yaw", "tilt", "roll", "lean", "side", "twist", "nod", "look")
"""Pelvis (metres; degrees of heading, forward, left up), trunk over pelvis, head (degrees)."""
FOOT = ("x", "y", "z", "yaw", "heel", "toe", "bend", "out")
"""Ground point under the ankle, metres; heading, heel up, toes up, toe bend, knee out, degrees."""
HAND = ("hx", "hy", "hz", "ex", "ey", "ez", "gx", "gy", "gz", "w", "flex")
"""Hand in the chest's frame, pole of the elbow, hand over the ground, its weight, wrist bend."""
CHANNELS = BODY + tuple(side + name for side in "lr" for name in FOOT + HAND)

_AHEAD = 0.03
"""How far the pelvis stands ahead of the ankles, metres on the standard body."""
ELBOW_BACK = (0.45, -0.45, -0.75)
HANG = (0.10, -0.95, 0.10)
Posture = dict[str, float]


def hands(left: tuple[float, float, float], right: tuple[float, float, float]) -> Posture:
    """Channel values that put the hands at (outward, up, ahead), elbows at rest."""
    values = dict(zip(("lhx", "lhy", "lhz"), left)) | dict(zip(("rhx", "rhy", "rhz"), right))
    for side in "lr":
        values |= dict(zip((f"{side}ex", f"{side}ey", f"{side}ez"), ELBOW_BACK))
        values |= {f"{side}w": 0.0, f"{side}flex": 0.0}
    return values


_UPRIGHT: Posture = {"dh": 0.0, "dz": 0.0, "tilt": 0.0, "lean": 0.0, "nod": 0.0}
STAND = _UPRIGHT | hands(HANG, HANG)
BALL_HOLD = (-0.13, -0.38, 0.52)
HOLD = (
    _UPRIGHT | {"dh": -0.09, "dz": -0.04, "tilt": 14.0, "lean": 8.0} | hands(BALL_HOLD, BALL_HOLD)
)
FISTS = (-0.10, -0.10, 0.42)
READY = _UPRIGHT | {"dh": -0.06, "tilt": 4.0, "lean": 10.0, "nod": 6.0} | hands(FISTS, FISTS)
SEATED = _UPRIGHT | {"dh": -0.40, "dz": -0.40, "tilt": -4.0, "lean": 6.0}
SEATED |= hands((0.0, -0.62, 0.52), (0.0, -0.62, 0.52))


class Take:
    """A take in the making.

    Parameters
    ----------
    person : who performs.
    name : of the capture; with ``seed`` it determines every random choice.
    rest : the posture that actions return to; ``width`` : feet apart, metres.
    """

    def __init__(self, person: Performer, name: str, seed: int, rest: Posture = STAND) -> None:
        self.person, self.name, self.rest = person, name, rest
        self.random = np.random.RandomState(zlib.crc32(f"{seed}/{person.name}/{name}".encode()))
        self.now = 0.0
        self.place = np.array([0.0, 0.0, 0.0])
        self.keys: dict[str, dict[float, float]] = {name: {} for name in CHANNELS}
        self.segments: list[tuple[str, float, float]] = []
        self.events: list[tuple[float, str, str, str]] = []
        self._tempo = person.tempo * self.random.uniform(0.93, 1.07)
        self.vigour = person.vigour * self.random.uniform(0.93, 1.07)
        self.width = 0.19 * person.stance * person.scale
        for time in (-1.0, 0.0):
            self.key(time, **dict.fromkeys(CHANNELS, 0.0))
            self.set_feet(time)
            self.posture(time, rest)

    # --- time -------------------------------------------------------------------------------

    def beat(self, seconds: float) -> float:
        """How long this performer takes for what usually lasts ``seconds``."""
        return seconds / self._tempo

    def begin(self) -> float:
        """Hold every channel until now, and return the time."""
        for name in CHANNELS:
            self.key(self.now, **{name: self.last(name)})
        return self.now

    def end(self, label: str, time: float) -> None:
        """Close an action that began at the last end; its truth is ``label``."""
        self.segments.append((label, self.now, time))
        self.now = time

    def event(self, time: float, event: str, joint: str, other: str) -> None:
        """Note an instant: what happens at which joint with what."""
        self.events.append((time, event, joint, other))

    # --- keys -------------------------------------------------------------------------------

    def key(self, time: float, **values: float) -> None:
        """Set channels at a time."""
        for name, value in values.items():
            self.keys[name][round(time, 5)] = float(value)

    def last(self, name: str) -> float:
        """The latest value of a channel."""
        return self.keys[name][max(self.keys[name])]

    def world(self, x: float, z: float) -> tuple[float, float]:
        """World ground point of a point of the place frame, both in metres."""
        yaw = np.deg2rad(self.place[2])
        cosine, sine = np.cos(yaw), np.sin(yaw)
        return self.place[0] + x * cosine + z * sine, self.place[1] - x * sine + z * cosine

    def pelvis(self, time: float, dx: float = 0.0, dh: float | None = 0.0, dz: float = 0.0) -> None:
        """Put the pelvis over a point of the place frame, ``dh`` above standing height if given."""
        scale = self.person.scale
        x, z = self.world(dx * scale, (dz + _AHEAD) * scale)
        self.key(time, px=x, pz=z)
        if dh is not None:
            self.key(time, py=self.height(dh))

    def height(self, dh: float) -> float:
        """The pelvis's height, metres, ``dh`` above standing (standard body)."""
        return self.person.leg * 0.993 + (0.08 + dh) * self.person.scale

    def posture(self, time: float, posture: Mapping[str, float], turn: bool = True) -> None:
        """Reach a posture over the present place; ``turn`` : also face where the place faces."""
        values = {name: value for name, value in posture.items() if name in self.keys}
        values["lean"] = values.get("lean", 0.0) + self.person.lean
        values = {"roll": 0.0, "side": 0.0, "twist": 0.0, "look": 0.0} | values
        self.pelvis(time, dh=posture.get("dh", 0.0), dz=posture.get("dz", 0.0))
        self.key(time, **values)
        if turn:
            self.key(time, yaw=self.place[2])

    def relax(self, time: float) -> None:
        """Return to the posture of rest."""
        self.posture(time, self.rest)

    def hand(
        self,
        side: str,
        time: float,
        place: tuple[float, float, float],
        elbow: tuple[float, float, float] | None = None,
        flex: float = 0.0,
    ) -> None:
        """A hand at (outward, up, ahead) from its shoulder, arm lengths, in the chest's frame."""
        values = dict(zip(("hx", "hy", "hz"), place)) | {"w": 0.0, "flex": flex}
        values |= dict(zip(("ex", "ey", "ez"), elbow or ELBOW_BACK))
        self.key(time, **{side + name: value for name, value in values.items()})

    def reach(self, side: str, time: float, ground: tuple[float, float, float]) -> None:
        """A hand at (outward, up, ahead) from the ground under the pelvis, metres."""
        values = dict(zip(("gx", "gy", "gz"), ground)) | {"w": 1.0}
        self.key(time, **{side + name: value for name, value in values.items()})

    # --- feet -------------------------------------------------------------------------------

    def stance(self, side: str, widen: float = 0.0) -> tuple[float, float, float]:
        """Where a foot stands in the present place: world x, z, metres, and heading, degrees."""
        sign = 1.0 if side == "l" else -1.0
        x, z = self.world(sign * (self.width / 2 + widen / 2), 0.0)
        return x, z, self.place[2] + sign * self.person.splay

    def set_feet(self, time: float) -> None:
        """Put both feet where the present place has them."""
        for side in "lr":
            x, z, yaw = self.stance(side)
            self.key(time, **{f"{side}x": x, f"{side}z": z, f"{side}yaw": yaw})

    def step(
        self,
        side: str,
        lift: float,
        land: float,
        to: tuple[float, float, float],
        height: float = 0.06,
        roll: tuple[float, float] = (12.0, 0.0),
    ) -> None:
        """Move a foot: lifted at ``lift``, landed at ``land`` at world (x, z, heading).

        height : of the swing, metres; roll : heel up before lifting, toes up at landing, degrees.
        """
        swing, names = land - lift, ("x", "z", "yaw")
        landed = max(self.keys[f"{side}y"])
        before = max(lift - 0.32, landed + 0.05, max(self.keys[f"{side}heel"]))
        before = min(before, lift - 0.02)
        up, down = roll
        for name, value in zip(names, to):
            self.key(lift + 0.08 * swing, **{side + name: self.last(side + name)})
            self.key(land - 0.05 * swing, **{side + name: value})
        self._curve(side, "y", (lift, 0.0), (lift + 0.45 * swing, height), (land, 0.0))
        self._curve(side, "heel", (before, 0.0), (lift, up), (lift + 0.6 * swing, 0.0))
        self._curve(side, "bend", (before, 0.0), (lift, 0.9 * up), (lift + 0.3 * swing, 0.0))
        if down:
            after = land + 0.18 * swing
            times = (lift + 0.5 * swing, land - 0.05 * swing, after)
            self._curve(side, "toe", (times[0], 0.0), (times[1], down), (after, 0.0))
        self.event(lift, "foot_off", f"{side}_ankle", "ground")
        self.event(land, "foot_strike", f"{side}_ankle", "ground")

    def _curve(self, side: str, name: str, *keys: tuple[float, float]) -> None:
        for time, value in keys:
            self.key(time, **{side + name: value})

    # --- the result -------------------------------------------------------------------------

    @property
    def n_frames(self) -> int:
        """Frames of the take, of which the last begins at or before the end."""
        return round(self.now * FPS)

    def curves(self) -> rig.Channels:
        """Every channel at every frame, before it wanders: name -> array (frames,)."""
        times = np.arange(self.n_frames) / FPS
        values = {}
        for name, keys in self.keys.items():
            at = dict(sorted(keys.items()))
            at[max(at) + 1.0] = at[max(at)]
            curve = PchipInterpolator(list(at), list(at.values()), extrapolate=False)
            values[name] = curve(times.clip(min(at), max(at)))
            if name[1:] not in FOOT:
                values[name] = _smoothed(values[name])
        return values

    def clip(self) -> Clip:
        """The take as a clip on the performer's skeleton."""
        values, person = self.curves(), self.person
        bones = skeleton(person)
        for name, size in _SWAY.items():
            values[name] = values[name] + person.sway * size * self._wander()
        local, root = rig.solve(values, person, bones)
        upper = [joint for joint, (role, _) in enumerate(ROLES) if role[2:] not in _LEG_JOINTS]
        shaken = self._tremor((len(root), len(upper), 3)) * np.deg2rad(person.tremor)
        shaken[:, 0] = 0.0
        local[:, upper] = rotation.multiply(local[:, upper], rotation.exp(shaken))
        return Clip(bones, FPS, local, root, unit=0.01)

    def _wander(self) -> FloatArray:
        """A slow random curve (frames,) of size about 1, the same at every length of take."""
        times = np.arange(self.n_frames) / FPS
        rates, phases = self.random.uniform(0.12, 0.7, 3), self.random.uniform(0.0, 1.0, 3)
        return sum(np.sin(2 * np.pi * (r * times + p)) for r, p in zip(rates, phases)) / 1.5

    def _tremor(self, shape: tuple[int, ...]) -> FloatArray:
        """Random values of deviation about 1, smooth over some three frames of the first axis."""
        rough = self.random.uniform(-1.0, 1.0, (shape[0] + 2, *shape[1:]))
        return rough[:-2] + rough[1:-1] + rough[2:]


_LEG_JOINTS = ("hip", "knee", "ankle", "toe")
_SWAY = {
    "px": 0.003, "pz": 0.003, "yaw": 0.5, "tilt": 0.4, "roll": 0.3, "lean": 0.8, "side": 0.6,
    "twist": 0.9, "nod": 1.5, "look": 2.0,
    "lhx": 0.012, "lhy": 0.010, "lhz": 0.015, "rhx": 0.012, "rhy": 0.010, "rhz": 0.015,
}  # fmt: skip
"""Size of the slow wander, in the channel's unit."""


def _smoothed(values: FloatArray) -> FloatArray:
    """Weights 1 4 6 4 1 over five frames, the ends repeated."""
    padded = np.pad(values, 2, mode="edge")
    return np.convolve(padded, np.array([1, 4, 6, 4, 1]) / 16.0, mode="valid")
