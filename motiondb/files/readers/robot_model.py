"""Reader of robots in MJCF (MuJoCo's XML) and URDF: links, hinges and slides.

MJCF: the tree below the worldbody that has the most joints, with its default classes
(``class``, ``childclass``), ``compiler`` (angle, eulerseq, autolimits), orientations (quat, euler,
axisangle, xyaxes, zaxis), frames, and several joints a body. Joints of the first body that place
the robot in the world (free, or slides) are left to the motion. URDF: ``origin rpy``, revolute,
continuous, prismatic and fixed joints, ``mimic``. Masses, shapes, sensors and actuators are
skipped. Refused: ball and planar joints, and MJCF that only a compiler unfolds (attach, replicate,
composite). A model is read without entities and document types. Files that a model includes are
put in its place when it is read from a folder (:func:`whole_model`); they lie beside it.

Source: https://mujoco.readthedocs.io/en/stable/XMLreference.html; https://wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from motiondb.body import rotation
from motiondb.body.hinges import Joint, Robot
from motiondb.errors import CaptureError
from motiondb.files.text import clean_bytes, decode, quoted
from motiondb.records import FloatArray

_MOST_BYTES, _MOST_LINKS, _MOST_INCLUDES = 20_000_000, 2000, 20
_DEPTH = 200  # Links below one another
_INCLUDE = re.compile(r"<include\s[^>]*?file\s*=\s*[\"']([^\"'<>]*)[\"'][^>]*?(/>|>\s*</include>)")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_UNFOLDED = ("attach", "replicate", "composite", "flexcomp")

Element = ElementTree.Element


def whole_model(data: bytes, path: Path, read: Callable[[Path], bytes]) -> bytes:
    """Return MJCF in which the content of included files stands in their place.

    `read` returns the bytes of a file. Included files must lie beside the model or below it.
    """
    if b"<include" not in data:
        return data
    text, count = _COMMENT.sub("", _text(data, path)), 0
    while (found := _INCLUDE.search(text)) is not None:
        name, count = found[1], count + 1
        if count > _MOST_INCLUDES or len(text) > _MOST_BYTES:
            raise CaptureError(
                path, f"expected at most {_MOST_INCLUDES} included files, found more. Join them."
            )
        if not re.fullmatch(r"(\./)?(\w[\w .()+-]*/)*\w[\w .()+-]*", name):
            raise CaptureError(
                path,
                f"expected included files beside or below the model, found {quoted(name, 100)}. "
                "Put the file there, or save the model as one file.",
            )
        inner = _root(_text(read(path.parent / name), path), path.parent / name)
        content = "".join(ElementTree.tostring(part, "unicode") for part in inner)
        text = text[: found.start()] + _COMMENT.sub("", content) + text[found.end() :]
    return text.encode()


def read_robot(data: bytes, path: object) -> Robot:
    """Read the robot in the bytes of an MJCF or URDF file (CaptureError)."""
    root = xml_root(data, path)
    if root.tag == "mujoco":
        robot = _Mjcf(root, path).robot()
    elif root.tag == "robot":
        robot = _read_urdf(root, path)
    else:
        raise CaptureError(
            path, f"expected MJCF or URDF, found XML of {quoted(root.tag, 40)}. Give another file."
        )
    arrays = (robot.places, robot.turns)
    values = [v for joint in robot.joints for v in (*joint.axis, *joint.anchor, joint.ref)]
    if not all(np.isfinite(array).all() for array in arrays) or not np.isfinite(values).all():
        raise CaptureError(path, "expected finite numbers in the model, found others. Mend it.")
    return robot


def xml_root(data: bytes, path: object) -> Element:
    """Return the outermost element of a model (CaptureError)."""
    return _root(_text(data, path), path)


def _text(data: bytes, path: object) -> str:
    """Return the text of a model without its declaration."""
    if len(data) > _MOST_BYTES:
        raise CaptureError(
            path, f"expected a model of at most {_MOST_BYTES / 1e6:g} MB, found more. Give another."
        )
    text = decode(clean_bytes(data, path)).lstrip()
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise CaptureError(path, "expected XML without a DOCTYPE, found one. Take it out.")
    return re.sub(r"^<\?xml[^>]*\?>", "", text)


def _root(text: str, path: object) -> Element:
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        line = error.position[0]
        raise CaptureError(
            path, [(line, f"expected XML, found a fault ({error}). Mend the model.")]
        ) from None


def _numbers(element: Element, name: str, count: int, default: str, path: object) -> FloatArray:
    """Return numbers of an attribute; at most `count`, where the others have defaults."""
    given = element.get(name, default)
    try:
        values = [float(word) for word in given.split()]
    except ValueError:
        values = []
    if len(values) != count:
        raise CaptureError(
            path,
            f"expected {count} numbers as {name} of {element.tag} "
            f"{quoted(element.get('name', ''), 60)}, found {quoted(given, 60)}. Mend the model.",
        )
    return np.array(values)


def _unit(vector: FloatArray, what: str, path: object) -> FloatArray:
    length = float(np.linalg.norm(vector))
    if not 1e-9 < length < math.inf:
        raise CaptureError(
            path, f"expected {what} with a direction, found {vector.tolist()}. Mend the model."
        )
    return vector / length


@dataclass
class _Tree:
    """Links and joints while they are read."""

    links: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    places: list[FloatArray] = field(default_factory=list)
    turns: list[FloatArray] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)

    def add(self, name: str, parent: int, place: FloatArray, turn: FloatArray, path: object) -> int:
        """Add a link and return its number."""
        number = len(self.links)
        depth, above = 0, parent
        while above >= 0:
            depth, above = depth + 1, self.parents[above]
        if number >= _MOST_LINKS or depth > _DEPTH:
            raise CaptureError(
                path,
                f"expected at most {_MOST_LINKS} links, {_DEPTH} below one another, found more. "
                "Leave out what is no part of the robot.",
            )
        name = name or f"link{number}"
        self.links.append(name if name not in self.links else f"{name}#{number}")
        self.parents.append(parent)
        self.places.append(place)
        self.turns.append(turn)
        return number

    def robot(self, name: str, notes: tuple[str, ...], path: object) -> Robot:
        """Return the robot; CaptureError if it cannot move."""
        if not self.joints:
            raise CaptureError(path, "expected a robot with hinges, found none. Give another file.")
        return Robot(
            name,
            tuple(self.links),
            np.array(self.parents),
            np.array(self.places),
            np.array(self.turns),
            tuple(self.joints),
            notes,
        )


class _Mjcf:
    """What all elements of a model share: its compiler and default classes."""

    def __init__(self, root: Element, path: object) -> None:
        self.path = path
        self.name = root.get("model", "")
        compiler: dict[str, str] = {}
        for element in root.iter("compiler"):
            compiler |= element.attrib
        if compiler.get("coordinate", "local") != "local":
            raise CaptureError(
                path, "expected local coordinates, found coordinate='global'. Save the model anew."
            )
        self.scale = 1.0 if compiler.get("angle", "degree") == "radian" else math.pi / 180.0
        self.euler = compiler.get("eulerseq", "xyz")
        if not re.fullmatch("[xyzXYZ]{3}", self.euler):
            raise CaptureError(
                path, f"expected three axes as eulerseq, found {quoted(self.euler, 20)}."
            )
        self.auto_limits = compiler.get("autolimits", "true") == "true"
        self.classes: dict[str, dict[str, str]] = {"main": {}}
        for element in root.findall("default"):
            self._read_defaults(element, {}, is_top=True)
        self.worlds = root.findall("worldbody")

    def _read_defaults(self, element: Element, above: Mapping[str, str], is_top: bool) -> None:
        """Read the joint of a default class, and the classes within it."""
        name = element.get("class", "main" if is_top else "")
        own = dict(above)
        if is_top:
            own |= self.classes["main"]
        for joint in element.findall("joint"):
            own |= joint.attrib
        self.classes[name] = own
        for inner in element.findall("default"):
            self._read_defaults(inner, own, is_top=False)

    def robot(self) -> Robot:
        """Return the tree with the most joints."""
        bodies = [body for world in self.worlds for body in world.iter("body")]
        inner = {id(b) for body in bodies for b in body.iter("body") if b is not body}
        tops = [body for body in bodies if id(body) not in inner]
        if not tops:
            raise CaptureError(self.path, "expected a robot's body, found none. Give another file.")
        counts = [sum(1 for _ in body.iter("joint")) for body in tops]
        top = tops[int(np.argmax(counts))]
        for name in _UNFOLDED:
            if any(True for _ in top.iter(name)):
                raise CaptureError(
                    self.path,
                    f"expected a model as the compiler saves it, found <{name}>. Save it with "
                    "MuJoCo (mj_saveLastXML), and give that file.",
                )
        tree = _Tree()
        self._body(top, tree, -1, (np.zeros(3), rotation.IDENTITY), self._class_above(top))
        others = [b.get("name", "?") for b, n in zip(tops, counts) if b is not top and n]
        told = f"Of the model's bodies {quoted(top.get('name', '?'), 60)} is read, not "
        notes = (told + ", ".join(others[:5]) + ".",) if others else ()
        return tree.robot(self.name, notes, self.path)

    def _class_above(self, top: Element) -> str:
        """Return the default class of the frames and worldbody around a body."""
        for world in self.worlds:
            for element in world.iter():
                if any(child is top for child in element):
                    return element.get("childclass", "main")
        return "main"

    def _place(self, element: Element) -> tuple[FloatArray, FloatArray]:
        """Return the place and the turn of a body or a frame."""
        place = _numbers(element, "pos", 3, "0 0 0", self.path)
        return place, rotation.normalize(self._turn(element))

    def _turn(self, element: Element) -> FloatArray:
        def numbers(name: str, count: int) -> FloatArray:
            return _numbers(element, name, count, "", self.path)

        if element.get("quat") is not None:
            return _unit(numbers("quat", 4), "a quaternion", self.path)
        if element.get("axisangle") is not None:
            x, y, z, angle = numbers("axisangle", 4)
            axis = _unit(np.array([x, y, z]), "axisangle", self.path)
            return rotation.from_axis_angle(axis, angle * self.scale)
        if element.get("euler") is not None:
            angles = np.rad2deg(numbers("euler", 3) * self.scale)
            turn = rotation.IDENTITY
            for angle, letter in zip(angles, self.euler):
                one = rotation.from_euler([angle], letter.upper())
                turn = rotation.multiply(*((turn, one) if letter.islower() else (one, turn)))
            return turn
        if element.get("xyaxes") is not None:
            both = numbers("xyaxes", 6)
            x_axis = _unit(both[:3], "xyaxes", self.path)
            y_axis = _unit(both[3:] - x_axis * (both[3:] @ x_axis), "xyaxes", self.path)
            columns = [x_axis, y_axis, np.cross(x_axis, y_axis)]
            return rotation.from_matrix(np.stack(columns, axis=-1))
        if element.get("zaxis") is not None:
            axis = _unit(numbers("zaxis", 3), "zaxis", self.path)
            return rotation.between(np.array([0.0, 0.0, 1.0]), axis)
        return rotation.IDENTITY

    def _body(
        self,
        body: Element,
        tree: _Tree,
        parent: int,
        within: tuple[FloatArray, FloatArray],
        default: str,
    ) -> None:
        """Add a body, its joints and the bodies below it; `within`: the frame in which it lies."""
        place, turn = self._place(body)
        place = within[0] + rotation.rotate(within[1], place)
        turn = rotation.multiply(within[1], turn)
        link = tree.add(body.get("name", ""), parent, place, turn, self.path)
        default = body.get("childclass", default)
        free = [*body.iterfind("freejoint")]
        joints = [(j, {**self._defaults(j, default), **j.attrib}) for j in body.iterfind("joint")]
        kinds = [given.get("type", "hinge") for _, given in joints]
        if parent < 0 and (free or {"free", "slide", "ball"} & {*kinds}):
            joints = []  # they place the robot in the world, as a motion does
        for element, given in joints:
            tree.joints.append(self._joint(element, given, link, len(tree.joints)))
        self._below(body, tree, link, (np.zeros(3), rotation.IDENTITY), default)

    def _below(
        self,
        element: Element,
        tree: _Tree,
        link: int,
        within: tuple[FloatArray, FloatArray],
        default: str,
    ) -> None:
        """Add the bodies of an element, also those in its frames."""
        for child in element:
            if child.tag == "body":
                self._body(child, tree, link, within, default)
            elif child.tag == "frame":
                place, turn = self._place(child)
                at = within[0] + rotation.rotate(within[1], place)
                inner = (at, rotation.multiply(within[1], turn))
                self._below(child, tree, link, inner, child.get("childclass", default))

    def _defaults(self, element: Element, default: str) -> Mapping[str, str]:
        name = element.get("class", default)
        if name not in self.classes:
            raise CaptureError(
                self.path,
                f"expected a default class of the model, found {quoted(name, 60)}. Mend the model.",
            )
        return self.classes[name]

    def _joint(self, element: Element, given: Mapping[str, str], link: int, number: int) -> Joint:
        """Return a hinge or a slide; others are refused."""
        name = element.get("name", f"joint{number}")
        kind = given.get("type", "hinge")
        if kind not in ("hinge", "slide"):
            raise CaptureError(
                self.path,
                f"expected hinges and slides, found the {quoted(kind, 20)} joint "
                f"{quoted(name, 60)}. Put three hinges in its place.",
            )
        whole = ElementTree.Element("joint", {**given, "name": name})
        scale = self.scale if kind == "hinge" else 1.0
        low, high = _numbers(whole, "range", 2, "0 0", self.path) * scale
        said = given.get("limited", "auto")
        has_limits = "range" in given if said == "auto" and self.auto_limits else said == "true"
        return Joint(
            name,
            link,
            _triple(_unit(_numbers(whole, "axis", 3, "0 0 1", self.path), "an axis", self.path)),
            _triple(_numbers(whole, "pos", 3, "0 0 0", self.path)),
            kind == "slide",
            (float(low), float(high)) if has_limits and low < high else None,
            float(_numbers(whole, "ref", 1, "0", self.path)[0]) * scale,
        )


def _triple(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


_MOVING = ("revolute", "continuous", "prismatic")


def _read_urdf(root: Element, path: object) -> Robot:
    """Read the links and joints of a URDF, parents first, children in the order of the file."""
    if macros := sum("xacro" in part.tag for part in root.iter()):
        raise CaptureError(
            path,
            f"expected a URDF, found {macros} elements of xacro, which stand for others. Expand "
            "them: xacro FILE -o MODEL.urdf.",
        )
    joints = [j for j in root.findall("joint") if j.find("child") is not None]
    names = [link.get("name", "") for link in root.findall("link")]
    below: dict[str, list[Element]] = {}
    parent_of: dict[str, str] = {}
    for joint in joints:
        above, child = (_link_of(joint, end) for end in ("parent", "child"))
        if child in parent_of or above not in names or child not in names:
            raise CaptureError(
                path,
                f"expected a tree of named links, found the joint {quoted(joint.get('name', ''))} "
                f"from {quoted(above)} to {quoted(child)}. Mend the model.",
            )
        parent_of[child] = above
        below.setdefault(above, []).append(joint)
    tops = [name for name in names if name not in parent_of]
    if not tops or len(names) > _MOST_LINKS:
        raise CaptureError(
            path, f"expected a tree of at most {_MOST_LINKS} links, found another. Mend the model."
        )
    tree, moving = _Tree(), dict[str, int]()
    for element, above, place, turn in _walk(tops[0], below, path):
        name = tops[0] if element is None else _link_of(element, "child")
        parent = -1 if element is None else tree.links.index(above)
        number = tree.add(name, parent, place, turn, path)
        if element is not None and element.get("type") in _MOVING:
            moving[element.get("name", "")] = number
    ordered = [j for j in joints if j.get("name", "") in moving and j.get("type") in _MOVING]
    firsts = {j.get("name", ""): n for n, j in enumerate(ordered) if j.find("mimic") is None}
    for joint in ordered:
        tree.joints.append(_urdf_joint(joint, moving[joint.get("name", "")], firsts, path))
    told = f"Of the model's links those below {quoted(tops[0], 60)} are read, not "
    notes = (told + ", ".join(tops[1:6]) + ".",) if len(tops) > 1 else ()
    return tree.robot(root.get("name", ""), notes, path)


def _link_of(joint: Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _walk(
    top: str, below: Mapping[str, list[Element]], path: object
) -> Iterator[tuple[Element | None, str, FloatArray, FloatArray]]:
    """Yield the joint above every link, the link above it, its place and its turn."""
    yield None, "", np.zeros(3), rotation.IDENTITY
    waiting = [(joint, top) for joint in reversed(below.get(top, []))]
    while waiting:
        joint, above = waiting.pop()
        kind = joint.get("type", "")
        if kind not in (*_MOVING, "fixed", "floating"):
            raise CaptureError(
                path,
                f"expected hinges, slides and fixed joints, found the {quoted(kind, 20)} joint "
                f"{quoted(joint.get('name', ''), 60)}. Put hinges and slides in its place.",
            )
        placed = joint.find("origin")
        origin = ElementTree.Element("origin") if placed is None else placed
        r, p, y = np.rad2deg(_numbers(origin, "rpy", 3, "0 0 0", path))
        turn = rotation.from_euler([y, p, r], "ZYX")
        yield joint, above, _numbers(origin, "xyz", 3, "0 0 0", path), turn
        child = _link_of(joint, "child")
        waiting += [(each, child) for each in reversed(below.get(child, []))]


def _urdf_joint(joint: Element, link: int, firsts: Mapping[str, int], path: object) -> Joint:
    """Return a moving joint of a URDF; `firsts`: the numbers of those that mimic no other."""
    name, kind = joint.get("name", ""), joint.get("type")
    about, limit, mimic = (joint.find(part) for part in ("axis", "limit", "mimic"))
    axis = ElementTree.Element("axis") if about is None else about
    limits, copied = None, None
    if limit is not None and kind != "continuous":
        ends = [float(_numbers(limit, end, 1, "0", path)[0]) for end in ("lower", "upper")]
        limits = (ends[0], ends[1]) if ends[0] < ends[1] else None
    if mimic is not None:
        other = mimic.get("joint", "")
        if other not in firsts:
            raise CaptureError(
                path,
                f"expected a joint for {quoted(name, 60)} to mimic, which mimics no other, found "
                f"{quoted(other, 60)}. Mend the model.",
            )
        factor, offset = (
            float(_numbers(mimic, n, 1, d, path)[0])
            for n, d in (("multiplier", "1"), ("offset", "0"))
        )
        copied = (firsts[other], factor, offset)
    unit = _unit(_numbers(axis, "xyz", 3, "1 0 0", path), "an axis", path)
    return Joint(
        name, link, _triple(unit), slides=kind == "prismatic", limits=limits, mimics=copied
    )
