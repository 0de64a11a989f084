"""Reader of ASF (Acclaim skeleton file): the body that AMC motions need.

Notation of a bone b: direction d_b and length l_b in the rest pose, axis rotation C_b, degrees of
freedom (a subset of rx, ry, rz; "dof" tells which values an AMC line holds, in which order). The
rotation of b is L_b = C_b R(dof) C_b^-1, where R turns about fixed axes in the order of the letters
of "axis": "XYZ" means R = Rz Ry Rx. In the rest pose all frames are parallel to the world's.

A joint of the clip stands at the *start* of its bone and carries the bone's name; its offset is
d l of the parent bone (0 below the root); a bone without children ends in an end site.
Source: Lander, "Working with Motion Capture File Formats", Game Developer, January 1998.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from motiondb.body import rotation
from motiondb.body.world import UNITS, find_unit
from motiondb.errors import CaptureError
from motiondb.files.text import Faults, clean_bytes, decode, number, quoted, shorten
from motiondb.files.units import scaled
from motiondb.records import FloatArray, Skeleton

CMU_LENGTH = 0.45  # ``length 0.45`` in the units means inches divided by 0.45
_ROOT_ORDER = ("tx", "ty", "tz", "rx", "ry", "rz")


@dataclass
class Bone:
    """One bone."""

    name: str  # Name of the bone
    line: int  # Line where it begins
    # Direction in the rest pose, world axes, any length
    direction: tuple[float, ...] = (0.0, 0.0, 0.0)
    length: float = 0.0  # Length in the file's unit
    # Angles of the axis rotation C, in the file's angle unit
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    order: str = "XYZ"  # Order of the axes of these angles, such as "XYZ"
    dof: tuple[str, ...] = ()  # Degrees of freedom in the order of the values of an AMC line


@dataclass(frozen=True, eq=False)
class AcclaimBody:
    """The parts of an ASF that its AMC files need."""

    skeleton: Skeleton  # Metres; joint 0 is "root"
    bones: tuple[Bone, ...]  # One for each joint; the root's ``dof`` is its order of channels
    axes: FloatArray  # (joints, 4): axis rotations C, quaternions w, x, y, z
    root_position: FloatArray  # (3,): added to the root's translation, metres
    unit: float  # Metres per length unit
    degrees: bool  # Whether angles are in degrees if the AMC does not say
    name: str  # Name of the file in messages
    notes: tuple[str, ...] = ()  # Sentences about the length unit


@dataclass
class _Raw:
    """The parts of the file read so far: sections, and faults with their lines."""

    bones: dict[str, Bone] = field(default_factory=dict)
    parents: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    faults: Faults = field(default_factory=list)

    def fault(self, line: int | None, sentence: str) -> None:
        """Add a fault."""
        self.faults.append((line, sentence))


def read_asf(data: bytes, path: object, *, unit: float | None = None) -> AcclaimBody:
    """Read the body in the bytes of an ASF file; `unit`: metres, None: as it says, or estimated."""
    raw = _read_sections(decode(clean_bytes(data, path)))
    joints = _order(raw)
    if raw.faults:
        raise CaptureError(path, shorten(raw.faults))
    degrees = not raw.units.get("angle", "deg").lower().startswith("rad")
    bones = tuple(raw.bones[name] for name in joints)
    skeleton = _skeleton(raw, bones)
    notes: tuple[str, ...] = ()
    if unit is None:
        length = number(raw.units.get("length", "")) or 1.0
        if abs(length - CMU_LENGTH) < 1e-6:
            unit = UNITS["cmu"]
        else:
            unit, notes = find_unit(skeleton)
    return AcclaimBody(
        skeleton=scaled(skeleton, unit),
        bones=bones,
        axes=np.array([axis_rotation(bone.axis, bone.order, degrees) for bone in bones]),
        root_position=np.array(raw.position) * unit,
        unit=unit,
        degrees=degrees,
        name=str(path),
        notes=notes,
    )


def axis_rotation(angles: tuple[float, ...] | FloatArray, order: str, degrees: bool) -> FloatArray:
    """Rotation (..., 4) of turns (..., n) about fixed axes, the first letter applied first.

    >>> axis_rotation((0.0, 0.0, 90.0), "XYZ", True).round(3)
    array([0.707, 0.   , 0.   , 0.707])
    """
    values = np.asarray(angles, dtype=float)
    return rotation.from_euler((values if degrees else np.rad2deg(values))[..., ::-1], order[::-1])


def _read_sections(text: str) -> _Raw:
    """Read all sections of the text; other sections than the four that matter are skipped."""
    raw = _Raw()
    root = raw.bones["root"] = Bone("root", 1, dof=_ROOT_ORDER)
    section, bone = "", None
    for line, content in enumerate(text.split("\n"), start=1):
        words = content.split("#")[0].split()
        if not words:
            continue
        key = words[0].lower()
        if key.startswith(":"):
            section = key
            root.line = line if section == ":root" else root.line
        elif section == ":bonedata":
            bone = _read_bone_line(raw, bone, line, words)
        else:
            _read_line(raw, section, line, words)
    if bone is not None:
        _miss_end(raw, bone)
    return raw


def _miss_end(raw: _Raw, bone: Bone) -> None:
    raw.fault(bone.line, f"expected 'end' for bone {quoted(bone.name)}, found none.")


def _read_line(raw: _Raw, section: str, line: int, words: list[str]) -> None:
    """Read a line of the units, the root or the hierarchy."""
    key = words[0].lower()
    if section == ":units" and len(words) > 1:
        raw.units[key] = words[1]
    elif section == ":root":
        _read_root(raw, raw.bones["root"], line, words)
    elif section == ":hierarchy" and key not in ("begin", "end"):
        _read_children(raw, line, words)


def _read_bone_line(raw: _Raw, bone: Bone | None, line: int, words: list[str]) -> Bone | None:
    """Read a line of the bone data; return the bone that is open after it."""
    key = words[0].lower()
    if key == "begin":
        if bone is not None:
            _miss_end(raw, bone)
        return Bone("", line)
    if key == "end":
        _finish_bone(raw, bone, line)
        return None
    if bone is not None:
        _read_bone(raw, bone, line, words)
    return bone


def _read_root(raw: _Raw, root: Bone, line: int, words: list[str]) -> None:
    """Read a line of the root: its order of channels, axis, position or orientation."""
    key = words[0].lower()
    if key == "order":
        order = tuple(word.lower() for word in words[1:])
        if set(order) - set(_ROOT_ORDER) or len(set(order)) != len(order):
            shown = quoted(" ".join(words[1:]))
            raw.fault(line, f"expected an order of TX TY TZ RX RY RZ, found {shown}.")
        root.dof = order
    elif key == "axis" and len(words) > 1:
        root.order = _axis_order(raw, line, words[1])
    elif key == "position":
        raw.position = _numbers(raw, line, words, 3)
    elif key == "orientation":
        root.axis = _numbers(raw, line, words, 3)


def _read_bone(raw: _Raw, bone: Bone, line: int, words: list[str]) -> None:
    """Read a line of a bone; lines with other keys are skipped."""
    key = words[0].lower()
    if key == "name" and len(words) > 1:
        bone.name = words[1]
    elif key == "direction":
        bone.direction = _numbers(raw, line, words, 3)
    elif key == "length":
        bone.length = _numbers(raw, line, words, 1)[0]
    elif key == "axis":
        bone.axis = _numbers(raw, line, words, 3)
        bone.order = _axis_order(raw, line, words[4] if len(words) > 4 else "XYZ")
    elif key == "dof":
        bone.dof = tuple(word.lower() for word in words[1:])
        unknown = [word for word in bone.dof if word not in ("rx", "ry", "rz")]
        if unknown:
            raw.fault(
                line,
                f"expected rx, ry or rz as dof of {quoted(bone.name)}, found {quoted(unknown[0])}.",
            )
        elif len(set(bone.dof)) != len(bone.dof):
            raw.fault(line, f"expected each dof of {quoted(bone.name)} once, found one twice.")


def _axis_order(raw: _Raw, line: int, text: str) -> str:
    """Return an order of the three axes in capitals; a fault and XYZ where it is none."""
    if sorted(text.upper()) == ["X", "Y", "Z"]:
        return text.upper()
    shown = quoted(text.upper())
    raw.fault(line, f"expected an axis order such as XYZ, found {shown}.")
    return "XYZ"


def _finish_bone(raw: _Raw, bone: Bone | None, line: int) -> None:
    """Add a bone that is complete, or the fault that it has."""
    if bone is None:
        raw.fault(line, "expected 'begin' before 'end', found none.")
    elif not bone.name:
        raw.fault(bone.line, "expected a name for the bone, found none.")
    elif bone.name in raw.bones:
        raw.fault(bone.line, f"expected one bone {quoted(bone.name)}, found a second.")
    else:
        raw.bones[bone.name] = bone


def _read_children(raw: _Raw, line: int, words: list[str]) -> None:
    """Read a line of the hierarchy: a bone and its children."""
    for name in words:
        if name not in raw.bones:
            raw.fault(line, f"expected a bone of :bonedata, found {quoted(name)}.")
    for child in words[1:]:
        if child in raw.parents or child == "root":
            raw.fault(line, f"expected one parent for {quoted(child)}, found a second.")
        else:
            raw.parents[child] = words[0]


def _numbers(raw: _Raw, line: int, words: list[str], count: int) -> tuple[float, ...]:
    """Return the numbers after a key; a fault and zeros where some are none."""
    values = [number(word) for word in words[1 : count + 1]]
    known = [value for value in values if value is not None]
    if len(known) != count:
        shown = quoted(" ".join(words[1 : count + 1]) or "none")
        many = "a number" if count == 1 else f"{count} numbers"
        raw.fault(line, f"expected {many} after {words[0]}, found {shown}.")
        return (0.0,) * count
    return tuple(known)


def _order(raw: _Raw) -> list[str]:
    """Return the names of the joints, depth first from the root, children in the file's order."""
    children: dict[str, list[str]] = {}
    for child, parent in raw.parents.items():
        children.setdefault(parent, []).append(child)
    order, stack = [], ["root"]
    while stack:
        name = stack.pop()
        order.append(name)
        stack += reversed(children.get(name, []))
    reached = set(order)
    lost = [bone for name, bone in raw.bones.items() if name not in reached]
    if len(raw.bones) == 1:
        raw.fault(None, "expected bones in :bonedata, found none. Is this an ASF file?")
    elif len(order) == 1:
        raw.fault(None, "expected bones below root in :hierarchy, found none.")
    else:
        raw.faults += [
            (bone.line, f"expected a parent of {quoted(bone.name)} in :hierarchy, found none.")
            for bone in lost
        ]
    return [name for name in order if name in raw.bones]


def _skeleton(raw: _Raw, bones: tuple[Bone, ...]) -> Skeleton:
    """Return the skeleton in the file's unit."""
    numbers = {bone.name: joint for joint, bone in enumerate(bones)}
    parents = np.array([numbers.get(raw.parents.get(bone.name, ""), -1) for bone in bones])
    ends = np.array([_unit_vector(bone.direction) * bone.length for bone in bones])
    offsets = np.array([ends[parent] if parent >= 0 else np.zeros(3) for parent in parents])
    inner = set(parents.tolist())
    leaves = [joint for joint in range(1, len(bones)) if joint not in inner]
    return Skeleton(
        names=tuple(bone.name for bone in bones),
        parents=parents,
        offsets=offsets,
        end_sites=tuple(
            (j, (float(x), float(y), float(z))) for j in leaves for x, y, z in [ends[j]]
        ),
    )


def _unit_vector(direction: tuple[float, ...]) -> FloatArray:
    """Return a direction with length 1; zeros stay zeros."""
    return rotation.normalize(np.array(direction))
