"""Semantic rules: conditions of space and time on a placed action, and how far it is from them.

Notation of the paper: pos(Y, t) and dir(Y, t) are the place and the heading of the pelvis on the
ground at frame t of an instance Y. A scene has the probability exp(-sum f_k / c_k), up to a factor,
over its rules k::

    f_pos   = |pos(Y, t) - p0|                                metres     (1)
    f_dir   = |dir(Y, t) - theta0|, wrapped to [0, pi]        radians    (2)
    f_synch = |(t_j - t_i) - dt|                              seconds    (3)
    f_dist  = 0 if near <= |pos(Y, t) - p0| <= far, else 1    no unit    (4)
    f_line  = distance of pos(Y, t) from the segment p1 p2    metres     (5)

The paper prints (3) with t_i twice. (4) includes its bounds, also where a grammar's text writes <
or >. (5) takes the segment and not the whole line: a defender is between two points, not behind one
of them.

The ground has axes x and z in metres. Seen from above, x points to the right and z down the page. A
heading is an angle from +z towards +x in radians: (sin theta, cos theta).

A weight c_k has the unit of its f_k and is the deviation that costs 1. The paper prints no weights.
Ours are deviations that a viewer barely tolerates, chosen by hand; a rule that is either kept or
broken costs 10 if broken.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from motiondb.records import FloatArray

PASS_SPEED = 8.0
"""Speed of a passed ball, m/s, from which its time of flight is estimated. Chosen by hand: the
usual chest pass."""

SMALLEST = float(np.finfo(np.float64).tiny)
"""Smallest squared length of a segment, m^2, to avoid division by 0."""

THROUGHOUT, START, END, PATH, EVENT = "throughout", "start", "end", "path", "event"
"""Moments that every action has; EVENT is its event, or its middle if it has none. Any other moment
is the name of an event of its clip."""
LOWEST, HIGHEST, NEAREST = "lowest", "highest", "nearest"
INSTANTS = (LOWEST, HIGHEST, NEAREST)
"""Events that are found in the motion: ``lowest(head)``, ``nearest(r_wrist, partner.head)``."""


@dataclass(frozen=True)
class Spot:
    """A point on the ground."""

    x: float  # Distance to the right
    z: float  # Distance away from the baseline


Target = str | Spot  # A named place, a role ("receiver", "opponent"), a player, or a point


@dataclass(frozen=True)
class Moment:
    """The time at which a rule is evaluated."""

    # ``start``, ``end``, an event, ``throughout`` (the mean over the frames), or ``path``
    name: str = THROUGHOUT
    # For ``path`` the fraction of the action's distance that has been covered
    fraction: float = 0.0


@dataclass(frozen=True)
class PositionRule:
    """Be at ``target``; ``weight`` in metres."""

    target: Target
    moment: Moment = field(default_factory=Moment)
    weight: float = 0.3


@dataclass(frozen=True)
class DirectionRule:
    """Face ``target``, or a heading in radians; ``weight`` in radians."""

    target: Target | float
    moment: Moment = field(default_factory=Moment)
    weight: float = math.radians(20.0)
    turn: float = 0.0  # Angle from the target to the heading, rad: pi turns the back to it


@dataclass(frozen=True)
class SynchronisationRule:
    """Be ``lag`` seconds before one of ``actions`` of ``partner``; ``weight`` in seconds.

    The partner's action is timed at its own event, or at its middle if it has none. A lag of None
    is the time that a passed ball flies.
    """

    partner: str
    actions: tuple[str, ...]
    lag: float | None = 0.0
    moment: Moment = field(default_factory=Moment)
    weight: float = 0.1


@dataclass(frozen=True)
class DistanceRule:
    """Be ``near`` to ``far`` metres from ``target``, both included; ``weight`` has no unit."""

    target: Target
    near: float = 0.0
    far: float = math.inf
    moment: Moment = field(default_factory=Moment)
    weight: float = 0.1


def bounds_text(near: float, far: float) -> str:
    """Return the bounds of a distance as they are written.

    >>> bounds_text(0.5, 2.0), bounds_text(1.0, math.inf)
    ('0.5 m .. 2 m', '>= 1 m')
    """
    return f">= {near:g} m" if math.isinf(far) else f"{near:g} m .. {far:g} m"


@dataclass(frozen=True)
class LineRule:
    """Be on the segment from ``first`` to ``second``; ``weight`` in metres."""

    first: Target
    second: Target
    moment: Moment = field(default_factory=Moment)
    weight: float = 0.3


SemanticRule = PositionRule | DirectionRule | SynchronisationRule | DistanceRule | LineRule

RULE_NAMES: dict[type, str] = {
    PositionRule: "position",
    DirectionRule: "direction",
    SynchronisationRule: "synchronisation",
    DistanceRule: "distance",
    LineRule: "line",
}


@dataclass(frozen=True)
class Weights:
    """Weights of the terms that belong to no action; an infinite weight leaves its term out.

    The values are chosen by hand: a missing element of a diagram and a collision cost 10, a seam
    costs what it is.
    """

    user: float = 0.1  # W_1, missing elements of a diagram
    smooth: float = 1.0  # W_2, mismatch of poses and velocities at seams
    collision: float = 0.1  # W_3, whether characters touch that should not
    # W_4, metres travelled by all characters; the paper calls the term optional
    effort: float = math.inf


def bearing(position: FloatArray, target: FloatArray) -> FloatArray:
    """Return the headings (...), radians, from places (..., 2) to targets (..., 2), m.

    >>> bearing(np.array([0.0, 0.0]), np.array([[0.0, 2.0], [2.0, 0.0]])).tolist()
    [0.0, 1.5707963267948966]
    """
    away = np.subtract(target, position)
    return np.asarray(np.arctan2(away[..., 0], away[..., 1]))


def line_error(position: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return f_line, m: the distances of places (..., 2) from the segment between two points.

    >>> line_error(np.array([[1.0, 1.0], [3.0, 0.0]]), np.zeros(2), np.array([2.0, 0.0])).tolist()
    [1.0, 1.0]
    """
    return np.asarray(np.linalg.norm(position - nearest_on_line(position, first, second), axis=-1))


def nearest_on_line(position: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the points (..., 2) on the segment between two points that are nearest to places.

    >>> nearest_on_line(np.array([1.0, 1.0]), np.zeros(2), np.array([2.0, 0.0])).tolist()
    [1.0, 0.0]
    """
    along = np.subtract(second, first)
    length = np.maximum(np.sum(along * along, axis=-1), SMALLEST)
    share = np.clip(np.sum(np.subtract(position, first) * along, axis=-1) / length, 0.0, 1.0)
    return np.add(first, share[..., None] * along)
