"""Bodies that joints with several axes move, as OpenSim has them, and their forward kinematics.

Notation: the frame F of a joint is fixed to its parent, the frame M to its child. Three turns about
axes of F, one after the other as an axis that the body carries along, and three ways along axes of
F place M: X_FM = (R(a_1, f_1) R(a_2, f_2) R(a_3, f_3), b_1 f_4 + b_2 f_5 + b_3 f_6), where every f
is a function of coordinates. So X_child = X_parent X_F X_FM X_M^-1. A joint that is reversed places
F in M. Ground is the world.

Source: Seth, Sherman, Eastman, Delp, Minimal formulation of joint motion for biomechanisms,
Nonlinear Dynamics 62, 2010; Delp et al., OpenSim, IEEE Trans. Biomed. Eng. 54, 2007.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from motiondb.body import rotation
from motiondb.records import FloatArray

Function = Callable[[FloatArray], FloatArray]
"""Of the values of a coordinate (frames,)."""
Frame = tuple[FloatArray, FloatArray]
"""Place (..., 3), metres, and turn (..., 4)."""
AT_ORIGIN: Frame = (np.zeros(3), rotation.IDENTITY)


@dataclass(frozen=True, eq=False)
class Axis:
    """One of the six axes of a joint."""

    direction: FloatArray  # (3,): unit vector
    coordinate: str  # "" for one that none moves
    function: Function


@dataclass(frozen=True, eq=False)
class Link:
    """A body and the joint that moves it."""

    name: str
    parent: int  # -1: ground
    turns: tuple[Axis, ...]
    ways: tuple[Axis, ...]
    before: Frame = AT_ORIGIN  # F in the parent
    after: Frame = AT_ORIGIN  # M in the child
    is_reversed: bool = False


@dataclass(frozen=True, eq=False)
class Coordinate:
    """A number that moves joints."""

    name: str
    is_angle: bool  # Radians, else metres or coupled
    default: float
    # (name of another coordinate, function of its values), where that one gives this one
    follows: tuple[str, Function] | None = None


@dataclass(frozen=True, eq=False)
class BodyModel:
    """Links, parents first, and coordinates by their names."""

    name: str
    links: tuple[Link, ...]
    coordinates: Mapping[str, Coordinate]
    up: str = "y"  # The axis against gravity
    notes: tuple[str, ...] = ()


def compose(first: Frame, then: Frame) -> Frame:
    """Return the frame `then` of the frame `first` in the world of `first`."""
    turns = np.broadcast_to(first[1], np.broadcast_shapes(first[1].shape, then[1].shape))
    places = np.broadcast_to(then[0], (*turns.shape[:-1], 3))
    return first[0] + rotation.rotate(turns, places), rotation.multiply(turns, then[1])


def inverse(frame: Frame) -> Frame:
    """Return the world in a frame."""
    back = rotation.conjugate(frame[1])
    return -rotation.rotate(back, frame[0]), back


def with_followers(
    model: BodyModel, given: Mapping[str, FloatArray], n_frames: int
) -> dict[str, FloatArray]:
    """Return values (frames,) of all coordinates: given, following another, or the model's."""
    values = {name: np.full(n_frames, c.default) for name, c in model.coordinates.items()}
    values |= {name: value for name, value in given.items() if name in values}
    following = {
        name: coordinate.follows
        for name, coordinate in model.coordinates.items()
        if coordinate.follows is not None and name not in given
    }
    while following:  # those that follow others after these; in a circle, in the order of the file
        free = [name for name, (other, _) in following.items() if other not in following]
        for name in free or list(following):
            other, function = following.pop(name)
            values[name] = function(values[other])
    return values


def pose(model: BodyModel, values: Mapping[str, FloatArray], n_frames: int) -> Frame:
    """Place all links in the world: places (frames, links, 3) and turns (frames, links, 4)."""
    frames: list[Frame] = []
    for link in model.links:
        moved = _joint(link, values, n_frames)
        moved = inverse(moved) if link.is_reversed else moved
        within = compose(compose(link.before, moved), inverse(link.after))
        frames.append(within if link.parent < 0 else compose(frames[link.parent], within))
    return np.stack([f[0] for f in frames], axis=1), np.stack([f[1] for f in frames], axis=1)


def _joint(link: Link, values: Mapping[str, FloatArray], n_frames: int) -> Frame:
    """Return M in F, for every frame."""
    still = np.zeros(n_frames)
    turn = np.broadcast_to(rotation.IDENTITY, (n_frames, 4))
    place = np.zeros((n_frames, 3))
    for axis in link.turns:
        angle = axis.function(values.get(axis.coordinate, still))
        turn = rotation.multiply(turn, rotation.from_axis_angle(axis.direction, angle))
    for axis in link.ways:
        way = axis.function(values.get(axis.coordinate, still))
        place = place + way[:, None] * axis.direction
    return place, turn


def spline(x: FloatArray, y: FloatArray) -> Function:
    """Return the cubic spline through points whose ends have the third derivative of a cubic there.

    That is the spline of SIMM and OpenSim; beyond its ends it goes on straight.

    >>> cube = spline(np.arange(5.0), np.arange(5.0) ** 3)
    >>> cube(np.array([1.5, 5.0])).tolist()
    [3.375, 112.0]
    """
    from scipy.linalg import solve_banded

    n, steps = len(x), np.diff(x)
    slopes = np.diff(y) / steps
    # for c, a sixth of the second derivatives: above, on and below the diagonal
    bands, right = np.zeros((3, n)), np.zeros(n)
    bands[1] = 1.0
    bands[0, 2:], bands[1, 1:-1], bands[2, :-2] = (
        steps[1:],
        2.0 * (steps[:-1] + steps[1:]),
        steps[:-1],
    )
    right[1:-1] = np.diff(slopes)
    if n > 3:
        thirds = np.diff(np.diff(slopes) / (x[2:] - x[:-2])) / (x[3:] - x[:-3])
        bands[1, 0], bands[0, 1], right[0] = -steps[0], steps[0], steps[0] ** 2 * thirds[0]
        bands[2, -2], bands[1, -1] = steps[-1], -steps[-1]
        right[-1] = -(steps[-1] ** 2) * thirds[-1]
    elif n == 3:
        bands[0, 1] = bands[2, -2] = -1.0
    c = solve_banded((1, 1), bands, right)
    first = slopes - steps * (2.0 * c[:-1] + c[1:])
    last = slopes[-1] + steps[-1] * (c[-2] + 2.0 * c[-1])

    def value(at: FloatArray) -> FloatArray:
        k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, n - 2)
        d = np.clip(at, x[0], x[-1]) - x[k]
        inner = y[k] + d * (first[k] + d * (3.0 * c[k] + d * (c[k + 1] - c[k]) / steps[k]))
        beyond = np.where(at > x[-1], (at - x[-1]) * last, np.minimum(at - x[0], 0.0) * first[0])
        return np.asarray(inner + beyond)

    return value
