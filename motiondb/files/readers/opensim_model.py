"""Reader of OpenSim's models (.osim): bodies, joints and coordinates; without muscles and meshes.

Files of OpenSim 2 and 3 have a joint in every body; those of OpenSim 4 have a set of joints, whose
sockets name frames on bodies. Read are custom joints (axes with constants, lines, polynomials and
splines), pin, slider, weld, ball, gimbal, universal, planar and free joints, in either direction,
and coordinates that follow another one (CoordinateCouplerConstraint). Other joints are refused.
Angles are radians, orientations turns about x, y and z of the body.

Source: OpenSim's API documentation, https://simtk.org/api_docs/opensim/api_docs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from motiondb.body import coordinates, rotation
from motiondb.body.coordinates import AT_ORIGIN, Axis, BodyModel, Coordinate, Frame, Function, Link
from motiondb.errors import CaptureError
from motiondb.files.readers.robot_model import Element, xml_root
from motiondb.files.text import quoted
from motiondb.records import FloatArray

_MOST_BODIES = 2000
_MOVES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "PinJoint": ("z", ""),
        "SliderJoint": ("", "x"),
        "WeldJoint": ("", ""),
        "BallJoint": ("xyz", ""),
    }
    | {"GimbalJoint": ("xyz", ""), "UniversalJoint": ("xy", ""), "PlanarJoint": ("z", "xy")}
    | {"FreeJoint": ("xyz", "xyz")}
)  # Kind of joint -> axes of its turns and of its ways, in the order of its coordinates
_UNITS = dict(zip("xyz", np.eye(3)))
_PARTS = [[f"{kind}{n}" for n in (1, 2, 3)] for kind in ("rotation", "translation")]
_AXES = frozenset(name for part in _PARTS for name in part)


def _plain(value: FloatArray) -> FloatArray:
    return value


@dataclass(frozen=True)
class _Joint:
    """A joint, and the bodies that it joins."""

    element: Element
    parent: str
    child: str
    before: Frame
    after: Frame
    is_reversed: bool


def read_osim(data: bytes, path: object) -> BodyModel:
    """Read the bodies that are joined to the ground, parents first (CaptureError)."""
    root = xml_root(data, path)
    model = root.find("Model")
    if root.tag != "OpenSimDocument" or model is None:
        raise CaptureError(path, "expected a model of OpenSim, found another file. Give its .osim.")
    bodies = model.findall("BodySet/objects/Body")
    if len(bodies) > _MOST_BODIES:
        raise CaptureError(path, f"expected at most {_MOST_BODIES} bodies, found more.")
    if len(model.findall("JointSet/objects/*")) > _MOST_BODIES:
        raise CaptureError(path, f"expected at most {_MOST_BODIES} joints, found more.")
    joints = [*_joints_of_bodies(bodies, path), *_joints_of_set(model, path)]
    if not joints:
        raise CaptureError(
            path,
            "expected joints as OpenSim 2 or newer writes them, found none. Open the model with "
            "OpenSim, and save it again.",
        )
    tree, notes = _tree(joints)
    known: dict[str, Coordinate] = {}
    links = []
    for joint, parent, is_reversed in tree:
        names = [c.get("name", "") for c in joint.element.iter("Coordinate")]
        turns, ways = _axes(joint.element, names, path)
        child = joint.parent if is_reversed else joint.child
        before, after = joint.before, joint.after
        if is_reversed:
            before, after = after, before
        flipped = is_reversed != joint.is_reversed
        links.append(Link(child, parent, turns, ways, before, after, flipped))
        for element in joint.element.iter("Coordinate"):
            name = element.get("name", "")
            default = _floats(element, "default_value", 1, path)[0]
            known[name] = Coordinate(name, _is_angle(element, name, turns, ways), default)
    for name, follows in _couplers(model, path):
        if name in known and follows[0] in known:
            known[name] = Coordinate(name, known[name].is_angle, known[name].default, follows)
    gravity = _floats(model, "gravity", 3, path, (0.0, -1.0, 0.0))
    axis = int(np.argmax(np.abs(gravity)))
    up = "y" if not gravity.any() else "-" * bool(gravity[axis] > 0) + "xyz"[axis]
    return BodyModel(model.get("name", ""), tuple(links), known, up, notes)


def _joints_of_bodies(bodies: list[Element], path: object) -> Iterator[_Joint]:
    """Yield the joints of files of OpenSim 2 and 3."""
    for body in bodies:
        for joint in body.findall("Joint/*"):
            before, after = (
                _frame(joint, f"location{end}", f"orientation{end}", path)
                for end in ("_in_parent", "")
            )
            flag = joint.findtext("reverse", "").strip().lower() == "true"
            above = _last(joint.findtext("parent_body", ""))
            yield _Joint(joint, above, body.get("name", ""), before, after, flag)


def _joints_of_set(model: Element, path: object) -> Iterator[_Joint]:
    """Yield the joints of files of OpenSim 4."""
    everywhere = {f.get("name", ""): f for f in model.iter("PhysicalOffsetFrame")}
    for joint in model.findall("JointSet/objects/*"):
        own = {f.get("name", ""): f for f in joint.findall("frames/PhysicalOffsetFrame")}
        frames = {**everywhere, **own}
        ends = [_end(_socket(joint, f"{end}_frame"), frames, path) for end in ("parent", "child")]
        (parent, before), (child, after) = ends
        yield _Joint(joint, parent, child, before, after, False)


def _socket(element: Element, name: str) -> str:
    """Return what a socket names, as versions of OpenSim 4 write it."""
    for tag in (f"socket_{name}", f"socket_{name}_connectee_name"):
        if (text := element.findtext(tag)) is not None:
            return _last(text)
    for connector in element.findall("connectors/*"):
        if connector.get("name") == name:
            return _last(connector.findtext("connectee_name", ""))
    return ""


def _end(name: str, frames: Mapping[str, Element], path: object) -> tuple[str, Frame]:
    """Return the body on which a frame lies, and the frame in it."""
    at = AT_ORIGIN
    for _ in range(20):
        if name not in frames:
            return name, at
        element = frames[name]
        at = coordinates.compose(_frame(element, "translation", "orientation", path), at)
        name = _socket(element, "parent")
    raise CaptureError(path, f"expected frames on bodies, found {quoted(name)} on itself.")


def _last(text: str) -> str:
    """Return the last name of a path to a component."""
    return text.strip().rpartition("/")[2]


def _tree(joints: list[_Joint]) -> tuple[list[tuple[_Joint, int, bool]], tuple[str, ...]]:
    """Return joints from the ground on, with the number of the body above, and notes.

    Bodies that hang from the ground in several trees are told apart: the largest is kept.
    """
    starts = [j for j in joints if "ground" in (j.parent, j.child)]
    trees = [_from(start, joints) for start in starts]
    best = max(trees, key=len, default=[])
    inside = {name for joint, _, _ in best for name in (joint.parent, joint.child)} - {"ground"}
    left = {name for tree in trees for joint, _, _ in tree for name in (joint.parent, joint.child)}
    left -= {*inside, "ground"}
    told = f"Of the model's bodies those around {best[0][0].child} are read, not " if best else ""
    return best, (told + ", ".join(sorted(left)[:5]) + ".",) if left else ()


def _from(start: _Joint, joints: list[_Joint]) -> list[tuple[_Joint, int, bool]]:
    """Return the joints of the tree that begins with a joint of the ground."""
    number = {"ground": -1}
    tree = list[tuple[_Joint, int, bool]]()
    waiting = [(start, start.child == "ground")]
    while waiting:
        joint, is_reversed = waiting.pop(0)
        above, below = (joint.child, joint.parent)[:: 1 if is_reversed else -1]
        if below in number:
            continue  # a loop that another joint closes
        tree.append((joint, number[above], is_reversed))
        number[below] = len(tree) - 1
        for other in joints:
            if below in (other.parent, other.child) and other is not joint:
                waiting.append((other, other.child == below))
        waiting = [w for w in waiting if "ground" not in (w[0].parent, w[0].child)]
    return tree


def _axes(
    joint: Element, names: list[str], path: object
) -> tuple[tuple[Axis, ...], tuple[Axis, ...]]:
    """Return the axes of the turns and of the ways of a joint."""
    if joint.tag in _MOVES:
        moves = _MOVES[joint.tag]
        names = names + [""] * (len(moves[0] + moves[1]) - len(names))
        axes = [Axis(_UNITS[letter], name, _plain) for letter, name in zip("".join(moves), names)]
        return tuple(axes[: len(moves[0])]), tuple(axes[len(moves[0]) :])
    given = {a.get("name", ""): a for a in joint.findall("SpatialTransform/TransformAxis")}
    if joint.tag != "CustomJoint" or not {*given} <= _AXES or (names and not given):
        raise CaptureError(
            path,
            f"expected custom, {', '.join(k[:-5].lower() for k in _MOVES)} joints, found the "
            f"{quoted(joint.tag)} {quoted(joint.get('name', ''))}. Save the model with another "
            "joint in its place.",
        )
    found = [tuple(_axis(given[n], path) for n in part if n in given) for part in _PARTS]
    return found[0], found[1]


def _axis(element: Element, path: object) -> Axis:
    """Return an axis of a custom joint."""
    names = element.findtext("coordinates", "").split()
    inner = [child for child in element if child.tag not in ("coordinates", "axis")]
    function = _function(inner[0], path) if inner else _plain
    direction = _floats(element, "axis", 3, path)
    length = float(np.linalg.norm(direction))
    if len(names) > 1 or not length > 0:
        raise CaptureError(
            path,
            f"expected an axis with a direction and one coordinate, found {len(names)} coordinates "
            f"and {direction.tolist()} for {quoted(element.get('name', ''))}. Mend the model.",
        )
    return Axis(direction / length, names[0] if names else "", function)


def _function(element: Element, path: object) -> Function:
    """Return a function of one value."""
    if element.tag.lower() in ("function", "coupled_coordinates_function"):
        return _function(element[0], path) if len(element) else _plain
    if element.tag == "Constant":
        constant = _floats(element, "value", 1, path)[0]
        return lambda value: np.full_like(value, constant)
    if element.tag in ("LinearFunction", "PolynomialFunction"):
        line = _floats(element, "coefficients", None, path, (1.0, 0.0))
        return lambda value: np.asarray(np.polyval(line, value))
    if element.tag == "MultiplierFunction":
        scale = _floats(element, "scale", 1, path, (1.0,))[0]
        inner = [child for child in element if child.tag != "scale"]
        times = _function(inner[0], path) if inner else _plain
        return _scaled(scale, times)
    x, y = (_floats(element, name, None, path) for name in "xy")
    known = element.tag in ("SimmSpline", "NaturalCubicSpline", "natCubicSpline", "GCVSpline")
    if not (known or element.tag == "PiecewiseLinearFunction"):
        raise CaptureError(
            path,
            "expected constants, lines, polynomials and splines as functions of coordinates, found "
            f"{quoted(element.tag)}. Save the model with a spline in its place.",
        )
    if not (2 <= len(x) == len(y) and (np.diff(x) > 0).all()):
        raise CaptureError(path, f"expected a {element.tag} of 2 or more points with rising x.")
    if element.tag == "PiecewiseLinearFunction":
        return lambda value: np.interp(value, x, y)
    return coordinates.spline(x, y)


def _is_angle(element: Element, name: str, turns: tuple[Axis, ...], ways: tuple[Axis, ...]) -> bool:
    """Say whether a coordinate is an angle, which files may have in degrees."""
    said = element.findtext("motion_type", "").strip().lower()
    if said:
        return said == "rotational"
    probe = np.array([0.0, 0.3, 1.0])
    for axes, is_turn in ((turns, True), (ways, False)):
        for axis in axes:
            if axis.coordinate == name and np.allclose(np.abs(axis.function(probe)), probe):
                return is_turn
    return False


def _couplers(model: Element, path: object) -> Iterator[tuple[str, tuple[str, Function]]]:
    """Yield coordinates that follow one other, and how."""
    for coupler in model.iter("CoordinateCouplerConstraint"):
        others = coupler.findtext("independent_coordinate_names", "").split()
        function = coupler.find("coupled_coordinates_function")
        is_off = "true" in coupler.findtext("isDisabled", "").lower()
        is_off |= "false" in coupler.findtext("isEnforced", "").lower()
        if len(others) == 1 and function is not None and not is_off:
            name = coupler.findtext("dependent_coordinate_name", "").strip()
            scale = _floats(coupler, "scale_factor", 1, path, (1.0,))[0]
            yield name, (others[0], _scaled(scale, _function(function, path)))


def _scaled(scale: float, function: Function) -> Function:
    return lambda value: scale * function(value)


def _frame(element: Element, place: str, turn: str, path: object) -> Frame:
    """Return a frame by its place and its turns about x, y and z."""
    angles = np.rad2deg(_floats(element, turn, 3, path))
    return _floats(element, place, 3, path), rotation.from_euler(angles, "XYZ")


def _floats(
    element: Element, name: str, count: int | None, path: object, default: tuple[float, ...] = ()
) -> FloatArray:
    """Return the numbers in an element below another; zeros where there is none."""
    text = element.findtext(name, "")
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = [np.nan]
    if not text.strip():
        values = list(default) or [0.0] * (count or 0)
    if count not in (None, len(values)) or not np.isfinite(values).all():
        raise CaptureError(
            path,
            f"expected {count or ''} numbers as {name} of {element.tag} "
            f"{quoted(element.get('name', ''))}, found {quoted(text.strip())}. Mend the model.",
        )
    return np.array(values)
