"""The takes of an FBX file as clips: the work of the child process that reads one.

A file holds *takes* (animation stacks) of one or several skeletons. A take in which no joint of the
skeleton moves is left out. The label of a take is its name, after that of its skeleton if several
move. Every joint's place is measured in the world at every frame, with all scales; its rotation is
that of its axes, without them.

The nodes and takes of an FBX file, as the library ufbx reads them.

ufbx trusts its caller to keep every object alive that it handed out: a node whose list was freed
ends the process. :class:`Scene` keeps them. It is used only in the child process of
:mod:`motiondb.files.readers.fbx`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from motiondb.body import rotation
from motiondb.body.joint_names import is_person
from motiondb.body.kinematics import to_local
from motiondb.body.rates import find_rate
from motiondb.body.world import TYPICAL_LEG, body_size, checked_unit, find_unit
from motiondb.errors import CaptureError, suggestion
from motiondb.files.limits import MIN_FPS, ReadOptions, check_clip_size, check_rate
from motiondb.files.text import distinct, plain, quoted, take_name
from motiondb.files.units import scaled
from motiondb.records import Clip, FloatArray, Skeleton

_STAYS = 1e-5
"""Metres that a joint may move in its parent's frame without counting as moved: rounding of the
numbers of a file, far below the millimetre."""
_STILL = 1e-6  # Metres, and differences of quaternions, below which nothing moves in a take
_DENSER = 1.2  # How much denser than the frames of the scene keys must be to be believed
_BESIDE = 0.05  # Frames by which a key may miss a frame of the take
_ENDS = re.compile(r"(end|nub|endsite|tip)$")
_SMALL = 1e-9  # Determinants of scales below which a matrix has no directions
_NO_TAKE = "expected a take with animation"


@dataclass(frozen=True)
class _Body:
    """The joints of one skeleton; a joint's number is its place here."""

    name: str  # Of the person, for labels
    joints: tuple[int, ...]  # Numbers of nodes; parents come before children
    ends: tuple[int, ...]  # Leaf bones that only mark an end, numbers of nodes


class FbxFile:
    """The takes of an FBX file, named by ``labels``; a single one needs no name."""

    def __init__(
        self, data: bytes, path: object, options: ReadOptions, is_pose: bool = False
    ) -> None:
        """Open a file; ``is_pose``: for the pose in which its joints stand, in place of takes."""
        self._path, self._options, self._n_bytes = path, options, len(data)
        self._scene = Scene(data, path)
        self._bodies = _find_bodies(self._scene, path)
        self._keys = {take: self._scene.keys(take) for take in range(len(self._scene.takes))}
        self._keys[-1] = Keys(0.0, None)
        self._fps = options.fps or (MIN_FPS if is_pose else self._rate())
        self._found = {"": (-1, self._largest())} if is_pose else self._find_takes()
        self.labels = tuple(self._found)

    def chosen(self, label: str) -> str:
        """Return the label of a take, "" for the only one; CaptureError if there is none."""
        if not label and len(self.labels) > 1:
            raise CaptureError(
                self._path,
                f"expected the name of one of its {len(self.labels)} takes after #, found none. "
                f"There are: {', '.join(self.labels)}.",
            )
        if label and label not in self._found:
            raise CaptureError(
                self._path,
                f"expected a take, found {quoted(label)}. There are: {', '.join(self.labels)}."
                + suggestion(label, self.labels),
            )
        return label or self.labels[0]

    def clip(self, label: str) -> Clip:
        """Read a take of this label."""
        return self._read(*self._found[label])

    def _rate(self) -> float:
        """Return the frames per second of the scene, or of its keys where these are denser."""
        keys, fps = max(keys.rate for keys in self._keys.values()), self._scene.fps
        fps = keys if keys > _DENSER * fps else fps
        return find_rate(1.0 / check_rate(fps, self._path))[0]

    def _find_takes(self) -> dict[str, tuple[int, _Body]]:
        """Return take and skeleton by label, of those in which joints move."""
        pairs = [
            (take, body)
            for take in range(len(self._scene.takes))
            for body in self._bodies
            if self._moves(take, body)
        ]
        if not pairs:
            takes = [name for name, _, _ in self._scene.takes]
            actual = f"{len(takes)} in which no joint moves" if takes else "none"
            raise CaptureError(
                self._path,
                f"{_NO_TAKE} of the skeleton, found {actual}. Plot the animation onto the "
                "skeleton and export it with the file.",
            )
        several = len({body.name for _, body in pairs}) > 1
        names = distinct([take_name(self._scene.takes[take][0]) for take, _ in pairs])
        if several:
            names = [
                f"{body.name} {take_name(self._scene.takes[take][0])}".strip()
                for take, body in pairs
            ]
            names = distinct(names)
        return dict(zip(names, pairs))

    def _largest(self) -> _Body:
        """Return the skeleton with the most joints."""
        return max(self._bodies, key=lambda body: len(body.joints))

    def _times(self, take: int) -> FloatArray:
        """Return the times of the frames of a take, seconds."""
        if take < 0:
            return np.zeros(1)
        _, begin, end = self._scene.takes[take]
        seconds = end - begin
        if not (math.isfinite(begin) and math.isfinite(seconds) and seconds >= 0.0):
            return np.zeros(0)
        count = math.floor(seconds * self._fps + 1e-3) + 1
        n_joints = max(len(body.joints) for body in self._bodies)
        check_clip_size(count, n_joints, self._n_bytes, self._path, self._options.limits)
        span, frames = self._keys[take].span, np.arange(count)
        if span is not None:  # the frames of the take within its keys: the others stand still
            near = (begin + frames / self._fps - np.array(span)[:, None]) * self._fps
            frames = frames[(near[0] > _BESIDE - 1.0) & (near[1] < 1.0 - _BESIDE)]
        return begin + frames / self._fps

    def _moves(self, take: int, body: _Body) -> bool:
        """Say whether any joint of a skeleton moves in a take, at 20 of its frames."""
        times = self._times(take)
        if len(times) < 2:
            return False
        some = times[np.unique(np.linspace(0, len(times) - 1, 20).astype(int))]
        for number in _with_ancestors(self._scene.nodes, body.joints):
            place, turn, _ = self._scene.transforms(take, number, some)
            if np.ptp(place, axis=0).max() > _STILL or np.ptp(turn, axis=0).max() > _STILL:
                return True
        return False

    def _read(self, take: int, body: _Body) -> Clip:
        """Read the joints of a skeleton in a take."""
        places, turns = self._world(take, body)
        joints = {node: joint for joint, node in enumerate(body.joints)}
        parents = np.array([self._above(node, joints) for node in body.joints])
        n_joints = len(joints)
        local, offsets = to_local(parents, places[:, :n_joints], turns[:, :n_joints])
        ends = []
        for number, node in enumerate(body.ends, start=len(joints)):
            joint = self._above(node, joints)
            way = places[:, number] - places[:, joint]
            way = rotation.rotate(rotation.conjugate(turns[:, joint]), way)
            ends.append((joint, tuple(np.median(way, axis=0).tolist())))
        rest = np.median(offsets, axis=0)
        rest[0] = 0.0
        skeleton = Skeleton(
            tuple(self._scene.nodes[node].name for node in body.joints),
            parents,
            rest,
            tuple(ends),
        )
        unit, notes = self._unit(skeleton, offsets)
        notes += self._time_notes(take, len(places))
        offsets = offsets * unit
        moved = np.abs(offsets[:, 1:] - unit * rest[1:]).max(initial=0.0) > _STAYS
        return Clip(
            skeleton=scaled(skeleton, unit),
            fps=self._fps,
            local_rotations=rotation.unroll(local),
            root_positions=places[:, 0] * unit,
            joint_positions=offsets if moved else None,
            format="fbx",
            unit=unit,
            notes=notes,
        )

    def _time_notes(self, take: int, n_frames: int) -> tuple[str, ...]:
        """Say what of a take was left out, and whose rate was taken."""
        if take < 0:
            return ()
        notes = []
        _, begin, end = self._scene.takes[take]
        still = math.floor((end - begin) * self._fps + 1e-3) + 1 - n_frames
        if still > 0:
            notes.append(f"Left out {still} still frames before the first key and after the last.")
        keys, fps = self._keys[take].rate, self._scene.fps
        if not self._options.fps and keys > _DENSER * fps:
            notes.append(
                f"The scene has {fps:.6g} frames a second and the take {keys:.6g} keys a second: "
                f"{self._fps:.6g} is taken."
            )
        return tuple(notes)

    def _above(self, node: int, joints: dict[int, int]) -> int:
        """Return the joint from which a node hangs, -1 for none."""
        parent = self._scene.nodes[node].parent
        while parent >= 0 and parent not in joints:
            parent = self._scene.nodes[parent].parent
        return joints.get(parent, -1)

    def _world(self, take: int, body: _Body) -> tuple[FloatArray, FloatArray]:
        """Places and rotations (frames, joints + ends, 3 or 4), lengths as in the file."""
        times = self._times(take)
        wanted = (*body.joints, *body.ends)
        matrices: dict[int, FloatArray] = {}
        for number in _with_ancestors(self._scene.nodes, wanted):
            own = _matrix(*self._scene.transforms(take, number, times))
            parent = self._scene.nodes[number].parent
            matrices[number] = own if parent < 0 else _product(matrices[parent], own)
        places = np.stack([matrices[number][..., 3] for number in wanted], axis=1)
        turns = np.stack([_turn(matrices[number][..., :3]) for number in wanted], axis=1)
        return places, turns

    def _unit(self, skeleton: Skeleton, offsets: FloatArray) -> tuple[float, tuple[str, ...]]:
        """Return the metres per unit: given, as the file says, or from the size of the body."""
        if self._options.unit is not None:
            return self._options.unit, ()
        unit = self._scene.unit
        lengths = np.linalg.norm(np.median(offsets, axis=0), axis=-1)
        size, typical = body_size(skeleton, lengths)
        if typical == TYPICAL_LEG and 0 < unit < 1e6:
            return checked_unit(unit, size, typical)
        return (unit, ()) if 0 < unit < 1e6 else find_unit(skeleton)


def _with_ancestors(nodes: Sequence[Node], wanted: Iterable[int]) -> list[int]:
    """Return nodes and all their ancestors; parents come before children."""
    order: list[int] = []
    seen: set[int] = set()
    for number in wanted:
        chain = []
        while number >= 0 and number not in seen:
            seen.add(number)
            chain.append(number)
            number = nodes[number].parent
        order += reversed(chain)
    return order


def _matrix(place: FloatArray, turn: FloatArray, scale: FloatArray) -> FloatArray:
    """Return affine matrices (frames, 3, 4) of places, rotations and scales."""
    linear = rotation.to_matrix(turn) * scale[:, None, :]
    return np.concatenate([linear, place[:, :, None]], axis=-1)


def _product(outer: FloatArray, inner: FloatArray) -> FloatArray:
    """Return the product of affine matrices (frames, 3, 4)."""
    product = outer[..., :3] @ inner
    product[..., 3] += outer[..., 3]
    return product


def _turn(linear: FloatArray) -> FloatArray:
    """Rotations (frames, 4) of matrices; a mirrored frame has its first axis turned around."""
    x, y = rotation.normalize(linear[..., 0]), linear[..., 1]
    y = rotation.normalize(y - np.sum(x * y, axis=-1, keepdims=True) * x)
    z = np.cross(x, y)
    mirrored = np.sum(z * linear[..., 2], axis=-1, keepdims=True) < 0.0
    x, z = np.where(mirrored, -x, x), np.where(mirrored, -z, z)
    known = np.abs(np.linalg.det(np.stack([x, y, z], axis=-1)))[:, None] > _SMALL
    turns = rotation.from_matrix(np.stack([x, y, z], axis=-1))
    return np.where(known, turns, rotation.IDENTITY)


def _find_bodies(scene: Scene, path: object) -> tuple[_Body, ...]:
    """Find the skeletons of persons, else the one of most joints."""
    nodes = scene.nodes
    chosen = {node.number for node in nodes if node.is_bone}
    if not chosen:  # locators may be joints, as optical systems write them
        chosen = {node.number for node in nodes if node.is_null and node.parent >= 0}
    groups: dict[int, list[int]] = {}
    for number in sorted(chosen):
        groups.setdefault(_top(nodes, number), []).append(number)
    bodies = [_body(nodes, members, chosen) for members in groups.values() if len(members) > 1]
    if not bodies:
        kinds = "one bone" if chosen else "none"
        raise CaptureError(
            path,
            f"expected a skeleton of several bones, found {kinds} among {len(nodes) - 1} nodes. "
            "Export the skeleton with the file.",
        )
    persons = [body for body in bodies if _is_person(nodes, body)]
    if not persons:
        persons = [max(bodies, key=lambda body: len(body.joints))]
    names = distinct([body.name for body in persons])
    return tuple(_Body(name, body.joints, body.ends) for name, body in zip(names, persons))


def _top(nodes: Sequence[Node], number: int) -> int:
    """Return the ancestor of a node just below the root of the scene."""
    while nodes[number].parent >= 0 and nodes[nodes[number].parent].parent >= 0:
        number = nodes[number].parent
    return number


def _body(nodes: Sequence[Node], members: Sequence[int], chosen: set[int]) -> _Body:
    """Return the joints of a group of bones, with the node that joins them if it is none."""
    order = _with_ancestors(nodes, members)
    roots = [number for number in members if not _has_above(nodes, number, chosen)]
    inside = set(members)
    if len(roots) > 1:  # under one group or armature, which is then the root
        inside.add(_top(nodes, members[0]))
    parents = {nodes[number].parent for number in order if number in inside}
    ends = [
        number
        for number in order
        if number in inside and number not in parents and _marks_end(nodes[number].name)
    ]
    joints = tuple(number for number in order if number in inside and number not in ends)
    top = nodes[_top(nodes, members[0])].name
    first = nodes[joints[0]].name
    space = first.rpartition(":")[0]
    return _Body(take_name(space or top), joints, tuple(ends))


def _has_above(nodes: Sequence[Node], number: int, chosen: set[int]) -> bool:
    """Say whether a bone is an ancestor of a node."""
    parent = nodes[number].parent
    while parent >= 0 and parent not in chosen:
        parent = nodes[parent].parent
    return parent >= 0


def _marks_end(name: str) -> bool:
    """Say whether a leaf bone of this name only marks where its parent ends.

    >>> [_marks_end(name) for name in ("Head_end", "HeadTop_End", "Bip01 HeadNub", "LeftHand")]
    [True, True, True, False]
    """
    return bool(_ENDS.search(re.sub(r"[\s_.\-\d]", "", name.lower())))


def _is_person(nodes: Sequence[Node], body: _Body) -> bool:
    """Say whether the joints of a person are found by their names."""
    number = {node: joint for joint, node in enumerate(body.joints)}
    names = tuple(nodes[node].name for node in body.joints)
    ends = tuple(
        (number[p], (0.0, 0.0, 0.0)) for e in body.ends if (p := nodes[e].parent) in number
    )
    return is_person(Skeleton(names, np.full(len(names), -1), np.zeros((len(names), 3)), ends))


_EVEN = 0.02  # Largest deviation of the distances of keys that are evenly spaced, as a share
_MOST_CURVES = 60  # Curves whose keys are looked at: those of the first few joints


@dataclass(frozen=True)
class Node:
    """A node of the file."""

    number: int
    name: str
    parent: int  # -1 for the root of the scene
    is_bone: bool
    is_null: bool  # A locator or a group without an object


@dataclass(frozen=True)
class Keys:
    """When a take has keys."""

    rate: float  # Keys a second of the longest curve if they are even, else 0
    span: tuple[float, float] | None  # First and last key, seconds; None where motion goes on


class Scene:
    """An open file; it keeps every object of ufbx that others are reached from."""

    def __init__(self, data: bytes, path: object) -> None:
        self.path = path
        self._scene = _load(data, path)
        self._kept = [self._scene.nodes, self._scene.anim_stacks, self._scene.skin_clusters]
        self._nodes = list(self._kept[0])
        self._stacks = list(self._kept[1])
        self._anims = [stack.anim for stack in self._stacks]
        skinned = self._skinned()
        self.nodes = tuple(self._describe(node, skinned) for node in self._nodes)
        self.takes = tuple(
            (stack.name, float(stack.time_begin), float(stack.time_end)) for stack in self._stacks
        )
        settings = self._scene.settings
        self._kept.append(settings)
        self.unit = float(settings.unit_meters)
        self.fps = float(settings.frames_per_second)

    def _skinned(self) -> set[int]:
        """Return the numbers of the nodes that move a skin, whatever their kind."""
        found = set()
        for cluster in self._kept[2]:
            node = cluster.bone_node
            self._kept += [cluster, node]
            if node is not None:
                found.add(int(node.typed_id))
        return found

    def _describe(self, node: Any, skinned: set[int]) -> Node:  # noqa: ANN401  of a C library
        parent = node.parent
        bone, mesh, light, camera = node.bone, node.mesh, node.light, node.camera
        self._kept += [parent, bone, mesh, light, camera]
        number = int(node.typed_id)
        return Node(
            number,
            plain(node.name),
            -1 if parent is None else int(parent.typed_id),
            bone is not None or number in skinned,
            mesh is None and light is None and camera is None and parent is not None,
        )

    def keys(self, take: int) -> Keys:
        """Return when a take has keys."""
        curves = self._curves(take)
        longest: FloatArray = np.zeros(0)
        spans: list[tuple[float, float]] = []
        is_held = True
        for number, curve in enumerate(curves):
            keys, before, after = curve.keyframes, curve.pre_extrapolation, curve.post_extrapolation
            self._kept += [keys, before, after]
            if len(keys) < 2:
                continue
            spans.append((float(curve.min_time), float(curve.max_time)))
            is_held &= before.mode.value == 0 == after.mode.value
            if number < _MOST_CURVES and len(keys) > max(2, len(longest)):
                longest = np.array([key.time for key in keys])
        if not spans:
            return Keys(0.0, None)
        steps = np.diff(longest)
        step = float(np.median(steps)) if len(steps) else 0.0
        even = len(steps) > 1 and steps.min() > 0.0 and np.ptp(steps) <= 2.0 * _EVEN * step
        first, last = min(a for a, _ in spans), max(b for _, b in spans)
        return Keys(1.0 / step if even else 0.0, (first, last) if is_held else None)

    def _curves(self, take: int) -> list[Any]:
        """Return the curves of a take."""
        found = []
        layers = self._stacks[take].layers
        self._kept.append(layers)
        for layer in layers:
            values = layer.anim_values
            self._kept += [layer, values]
            for value in values:
                curves = list(value.curves)
                self._kept += [value, *curves]
                found += [curve for curve in curves if curve is not None]
        return found

    def transforms(
        self, take: int, number: int, times: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Places, rotations, scales (frames, 3 or 4) of a node; take -1: the pose in the file."""
        import ufbx

        node = self._nodes[number]
        rows = []
        for time in times.tolist():
            transform = (
                node.local_transform
                if take < 0
                else ufbx.evaluate_transform(self._anims[take], node, time)
            )
            (place, (x, y, z, w), scale) = transform
            rows.append((*place, w, x, y, z, *scale))
        table = np.array(rows)
        return table[:, :3], table[:, 3:7], table[:, 7:]


def _load(data: bytes, path: object) -> Any:  # noqa: ANN401  an object of a C library
    """Open the bytes of a file; what ufbx says of it becomes a CaptureError."""
    import ufbx

    try:
        scene = ufbx.load_memory(
            data,
            ignore_geometry=True,
            skip_skin_vertices=True,
            ignore_embedded=True,
            load_external_files=False,
            target_axes=ufbx.axes_right_handed_y_up,
            space_conversion=ufbx.SpaceConversion.TRANSFORM_ROOT,
            inherit_mode_handling=ufbx.InheritModeHandling.HELPER_NODES,
        )
    except (ufbx.TruncatedFileError, ufbx.EmptyFileError):
        raise CaptureError(
            path, "expected a whole FBX file, found one that is cut short. Export it again."
        ) from None
    except ufbx.UnrecognizedFileFormatError:
        raise CaptureError(
            path, "expected an FBX file, found other content. Check what the file is."
        ) from None
    except ufbx.OutOfMemoryError:
        raise MemoryError from None
    except ufbx.UfbxError as error:
        reason = quoted(str(error) or type(error).__name__, 80)
        raise CaptureError(
            path, f"expected an FBX file that can be read, found {reason}. Export it again."
        ) from None
    metadata = scene.metadata
    if metadata.file_format != ufbx.FileFormat.FBX:
        raise CaptureError(path, "expected an FBX file, found another format. Rename it.")
    return scene
