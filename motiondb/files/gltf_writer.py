"""Writer of glTF 2.0: an animated skeleton with a simple body, for Blender and browsers.

A scene holds several characters and a ball in one world. Every character is a node with its joints
and its body as children; the names of joints begin with the character's name, so that they are
unique. The ball is a sphere with a track of positions. All tracks belong to one animation, so that
a viewer plays the whole scene.

Every joint is a node; its rotation is a track of quaternions (x, y, z, w), and its translation is a
track where it moves. Each bone is drawn as an octahedron that a skin binds rigidly to its joint.
Metres, y up. ``.glb`` is the binary form, ``.gltf`` is JSON with the buffer embedded.
Source: Khronos, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.body import kinematics, rotation
from motiondb.body.retarget import to_clip
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import check_clip, write_atomically
from motiondb.records import Clip, FloatArray, Motion

FLOAT, USHORT, UINT = 5126, 5123, 5125  # Component types of glTF
_TYPES = MappingProxyType({1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"})
ARRAY, ELEMENTS = 34962, 34963  # Targets of buffer views: vertices, and indices of vertices
_WIDTH, _GIRDLE = 0.12, 0.2
"""Half width of an octahedron, and where it is widest, as shares of the bone's length. Chosen for
their look, like Blender's bones."""
_SHORTEST_BONE = 1e-4
"""Bones shorter than this (metres) are not drawn: an octahedron without size has no normals."""
_SLIDING = 0.02
"""A joint that moves farther than this (metres) in its parent's frame is not drawn as a bone."""
_MOVES = 1e-6
"""A joint that moves less than this (metres) in its parent's frame gets no translation track."""
ASSET = {"version": "2.0", "generator": "motiondb"}
BALL_RADIUS = 0.12  # Metres; a basketball of size 7 measures 0.749 to 0.780 m round (FIBA)
_BALL_COLOUR = (0.85, 0.42, 0.13)  # Red, green and blue of a basketball, 0 to 1
_RINGS, _SIDES = 8, 16
"""Parallels and meridians of the sphere: round enough at the size of a ball, and 240 triangles."""
_FACES = ((0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4), (5, 1, 2), (5, 2, 3), (5, 3, 4), (5, 4, 1))
"""Corners of the eight triangles of an octahedron, counterclockwise from outside."""


Colour = tuple[float, float, float]


class Buffer:
    """A binary buffer that grows, with the views and accessors that describe it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: NDArray[np.generic], component: int, target: int | None = None) -> int:
        """Append an array (rows,) or (rows, columns); return the number of its accessor."""
        values = np.ascontiguousarray(values)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes}
        if target is not None:
            view["target"] = target
        self.views.append(view)
        self.data += values.tobytes()
        self.data += b"\0" * (-len(self.data) % 4)
        width = 1 if values.ndim == 1 else values.shape[1]
        columns = values.reshape(len(values), width)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": component,
                "count": len(values),
                "type": _TYPES[width],
                "min": columns.min(axis=0).tolist(),
                "max": columns.max(axis=0).tolist(),
            }
        )
        return len(self.accessors) - 1

    def described(self) -> dict[str, object]:
        """Return the entries of the document that describe the buffer."""
        return {
            "bufferViews": self.views,
            "accessors": self.accessors,
            "buffers": [{"byteLength": len(self.data)}],
        }


def write_gltf(
    motion: Clip | Motion, path: str | Path, owner: str = "", reduce_keys: float = 0.0
) -> tuple[str, ...]:
    """Write a clip or a motion as glTF (.glb or .gltf); see :func:`write_bvh`.

    Parameters
    ----------
    motion : Clip or Motion
        As in :func:`write_bvh`.
    path : str or Path
        The file.
    owner : str
        Who holds the rights, and a licence, for the file.
    reduce_keys : float
        Degrees, and centimetres, within which keys are left out; 0: a key a frame.

    Returns
    -------
    tuple of str
        How many keys were left out, if any should be.
    """
    path = Path(path)
    check_ending(path)
    clip = to_clip(motion)
    parts, buffer = _no_parts(), Buffer()
    check_clip(clip, path)
    roots = _add_body(clip, parts, buffer, "", "body", (0.35, 0.55, 0.8), reduce_keys)
    document, data = _document(roots, "motion", parts, buffer)
    document["asset"] = ASSET | ({"copyright": owner} if owner else {})
    write_document(document, data, path)
    if not reduce_keys:
        return ()
    counts = [buffer.accessors[sampler["input"]]["count"] for sampler in parts["samplers"]]
    return (
        f"keys: {sum(counts):,} of {len(counts) * clip.n_frames:,}, within {reduce_keys:g} degrees "
        f"and {reduce_keys:g} cm",
    )


def check_ending(path: Path) -> None:
    """Refuse other endings than .glb and .gltf (CaptureError)."""
    ending = path.suffix.lower()
    if ending not in (".glb", ".gltf"):
        raise CaptureError(path, f"expected the ending .glb or .gltf, found {ending!r}.")


def write_document(document: dict[str, object], data: bytes, path: Path) -> None:
    """Write a document and its buffer in the form of the path's ending, whole or not at all."""
    if path.suffix.lower() == ".glb":
        write_atomically(path, _glb(document, data))
        return
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document["buffers"] = [{"byteLength": len(data), "uri": uri}]
    write_atomically(path, json.dumps(document, separators=(",", ":")).encode())


def material(name: str, colour: Colour) -> dict[str, object]:
    """Return a matt material of one colour (red, green, blue, 0 to 1)."""
    return {
        "name": name,
        "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*colour, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        },
    }


def _rest_offsets(clip: Clip) -> FloatArray:
    """Return the joints' positions in their parents' frames in the first frame; the root at 0."""
    source = clip.skeleton.offsets if clip.joint_positions is None else clip.joint_positions[0]
    offsets = source.copy()
    offsets[0] = 0.0
    return offsets


def joint_nodes(clip: Clip, first: int = 0, prefix: str = "") -> list[dict[str, object]]:
    """Return one node for each joint, posed as in the first frame."""
    offsets = _rest_offsets(clip)
    offsets[0] = clip.root_positions[0]
    nodes: list[dict[str, object]] = []
    for joint, name in enumerate(clip.skeleton.names):
        node: dict[str, object] = {
            "name": f"{prefix}{name}",
            "translation": offsets[joint].tolist(),
            "rotation": _xyzw(clip.local_rotations[0, joint]).tolist(),
        }
        children = (first + np.flatnonzero(clip.skeleton.parents == joint)).tolist()
        if children:
            node["children"] = children
        nodes.append(node)
    return nodes


def _slides(clip: Clip) -> NDArray[np.bool_]:
    """Find the joints that move relative to their parent, without a bone (joints,)."""
    if clip.joint_positions is None:
        return np.zeros(len(clip.skeleton.names), dtype=bool)
    return np.asarray(np.ptp(clip.joint_positions, axis=0).max(axis=-1) > _SLIDING)


def body_mesh(clip: Clip, buffer: Buffer, number: int) -> dict[str, object]:
    """Return the mesh of octahedra from every joint to its children and end sites."""
    skeleton, offsets, slides = clip.skeleton, _rest_offsets(clip), _slides(clip)
    rest, _ = kinematics.forward(
        skeleton.parents,
        offsets,
        np.tile(rotation.IDENTITY, (1, len(offsets), 1)),
        np.zeros((1, 3)),
    )
    bones = [
        (int(p), offsets[j]) for j, p in enumerate(skeleton.parents) if p >= 0 and not slides[j]
    ]
    bones += [(joint, np.array(end)) for joint, end in skeleton.end_sites]
    bones = [(joint, bone) for joint, bone in bones if np.linalg.norm(bone) > _SHORTEST_BONE]
    if not bones:
        bones = [(0, np.array([0.0, 0.05, 0.0]))]
    corners = [_octahedron(rest[0, joint], bone) for joint, bone in bones]
    triangles = np.concatenate([points[np.array(_FACES)].reshape(-1, 3) for points in corners])
    sides = triangles.reshape(-1, 3, 3)
    normals = rotation.normalize(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]))
    joints = np.zeros((len(triangles), 4), np.uint16)
    joints[:, 0] = np.repeat([joint for joint, _ in bones], 3 * len(_FACES))
    weights = np.zeros((len(triangles), 4), np.float32)
    weights[:, 0] = 1.0
    attributes = {
        "POSITION": buffer.add(triangles.astype(np.float32), FLOAT, ARRAY),
        "NORMAL": buffer.add(np.repeat(normals, 3, axis=0).astype(np.float32), FLOAT, ARRAY),
        "JOINTS_0": buffer.add(joints, USHORT, ARRAY),
        "WEIGHTS_0": buffer.add(weights, FLOAT, ARRAY),
    }
    indices = buffer.add(np.arange(len(triangles), dtype=np.uint32), UINT, ELEMENTS)
    primitive = {"attributes": attributes, "indices": indices, "material": number}
    return {"name": "body", "primitives": [primitive]}


def _octahedron(start: FloatArray, bone: FloatArray) -> FloatArray:
    """Return the six corners of a bone: its start, four around its girdle, its end."""
    length = float(np.linalg.norm(bone))
    turn = rotation.between(np.array([0.0, 1.0, 0.0]), bone)
    side, girdle = _WIDTH * length, _GIRDLE * length
    local = np.array(
        [
            [0.0, 0.0, 0.0],
            [side, girdle, 0.0],
            [0.0, girdle, -side],
            [-side, girdle, 0.0],
            [0.0, girdle, side],
            [0.0, length, 0.0],
        ]
    )
    return start + rotation.rotate(np.broadcast_to(turn, (6, 4)), local)


def inverse_binds(clip: Clip, buffer: Buffer) -> dict[str, int]:
    """Return the accessor of each joint's inverse rest transform, a matrix by columns."""
    offsets = _rest_offsets(clip)
    rest = offsets.copy()
    for joint, parent in enumerate(clip.skeleton.parents):
        rest[joint] = offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
    matrices = np.tile(np.eye(4), (len(rest), 1, 1))
    matrices[:, 3, :3] = -rest
    return {"inverseBindMatrices": buffer.add(matrices.reshape(-1, 16).astype(np.float32), FLOAT)}


def tracks(
    clip: Clip, buffer: Buffer, first: int = 0, tolerance: float = 0.0
) -> tuple[list[dict[str, object]], list[dict[str, object]]]:
    """Return a rotation track for each joint, and a translation track where it moves."""
    turns = rotation.unroll(rotation.normalize(clip.local_rotations))
    samplers: list[dict[str, object]] = []
    channels: list[dict[str, object]] = []

    seconds = (np.arange(clip.n_frames) / clip.fps).astype(np.float32)
    all_times = buffer.add(seconds, FLOAT)

    def track(joint: int, kind: str, values: FloatArray) -> None:
        times = all_times
        if tolerance:
            kept = _keys(values, tolerance)
            values, times = values[kept], buffer.add(seconds[kept], FLOAT)
        values = _xyzw(values) if kind == "rotation" else values
        output = buffer.add(values.astype(np.float32), FLOAT)
        samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
        target = {"node": first + joint, "path": kind}
        channels.append({"sampler": len(samplers) - 1, "target": target})

    track(0, "translation", clip.root_positions)
    for joint in range(len(clip.skeleton.names)):
        track(joint, "rotation", turns[:, joint])
        if joint and clip.joint_positions is not None:
            places = clip.joint_positions[:, joint]
            if np.ptp(places, axis=0).max() > _MOVES:
                track(joint, "translation", places)
    return samplers, channels


def _keys(values: FloatArray, tolerance: float) -> list[int]:
    """Frames between which values (frames, 3 or 4) are interpolated within degrees, or cm.

    The key that is farthest off is added until none is (Ramer, Douglas and Peucker).
    """
    kept, spans = {0, len(values) - 1}, [(0, len(values) - 1)]
    while spans:
        low, high = spans.pop()
        share = np.arange(1, high - low) / max(high - low, 1)
        true, (first, last) = values[low + 1 : high], values[[[low], [high]]]
        if values.shape[1] == 4:
            cosines = np.abs(np.sum(rotation.slerp(first, last, share) * true, axis=1))
            off = np.degrees(2.0 * np.arccos(np.minimum(cosines, 1.0)))
        else:
            off = 100.0 * np.linalg.norm(first + share[:, None] * (last - first) - true, axis=1)
        if len(off) and off.max() > tolerance:
            middle = low + 1 + int(off.argmax())
            kept.add(middle)
            spans += [(low, middle), (middle, high)]
    return sorted(kept)


def _xyzw(q: FloatArray) -> FloatArray:
    """Return quaternions (w, x, y, z) in the order of glTF (x, y, z, w)."""
    return np.roll(q, -1, axis=-1)


def _glb(document: dict[str, object], data: bytes) -> bytes:
    """Return the binary container: a header, the JSON chunk, the buffer chunk."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = _chunk(b"JSON", text) + _chunk(b"BIN\0", data)
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunks)).to_bytes(4, "little") + chunks


def _chunk(kind: bytes, content: bytes) -> bytes:
    """Return a chunk with its length and kind before it."""
    return len(content).to_bytes(4, "little") + kind + content


@dataclass(frozen=True, eq=False)
class Character:
    """A person in a scene."""

    name: str  # Unique in the scene
    clip: Clip  # The motion in the world frame of the scene, metres, y up
    colour: Colour = (0.35, 0.55, 0.8)  # Red, green and blue, 0 to 1


def write_gltf_scene(
    characters: Sequence[Character],
    path: Path | str,
    ball: FloatArray | None = None,
    radius: float = BALL_RADIUS,
) -> None:
    """Write characters and an object (frames, 3), a ball of a radius, m, as glTF, whole or not."""
    path = Path(path)
    check_ending(path)
    write_document(*to_gltf_scene(characters, ball, path, radius), path)


def to_gltf_scene(
    characters: Sequence[Character],
    ball: FloatArray | None = None,
    path: object = "scene",
    radius: float = BALL_RADIUS,
) -> tuple[dict[str, object], bytes]:
    """Return the document of characters and a ball (frames, 3), and its buffer."""
    _check_scene(characters, ball, path)
    parts, buffer = _no_parts(), Buffer()
    roots = [_add_character(character, parts, buffer) for character in characters]
    if ball is not None and len(ball):
        roots.append(_add_ball(ball, characters[0].clip.fps, parts, buffer, radius))
    return _document(roots, "scene", parts, buffer)


_Parts = Mapping[str, list[dict[str, Any]]]


def _no_parts() -> _Parts:
    keys = ("nodes", "meshes", "materials", "skins", "samplers", "channels")
    return {key: [] for key in keys}


def _document(
    roots: list[int], name: str, parts: _Parts, buffer: Buffer
) -> tuple[dict[str, object], bytes]:
    """Return the document of parts with one animation of this name, and the buffer's bytes."""
    described = {key: parts[key] for key in ("nodes", "meshes", "materials", "skins")}
    animation = {key: parts[key] for key in ("samplers", "channels")}
    document: dict[str, object] = {
        "asset": ASSET,
        "scene": 0,
        "scenes": [{"nodes": roots}],
        **described,
        "animations": [{"name": name, **animation}],
        **buffer.described(),
    }
    return document, bytes(buffer.data)


def _check_scene(characters: Sequence[Character], ball: FloatArray | None, path: object) -> None:
    """Refuse a scene that cannot be written (CaptureError)."""
    names = [character.name for character in characters]
    if not names:
        raise CaptureError(path, "expected at least 1 character to write, found 0.")
    for name in names:
        if names.count(name) > 1:
            raise CaptureError(path, f"expected characters of different names, found two {name}.")
    for character in characters:
        check_clip(character.clip, path)
    if ball is not None and not np.isfinite(ball).all():
        raise CaptureError(path, "expected finite positions of the ball, found NaN or infinity.")


def _add_character(character: Character, parts: _Parts, buffer: Buffer) -> int:
    """Append a character's node, joints and body; return the number of its node."""
    node: dict[str, object] = {"name": character.name}
    number = len(parts["nodes"])
    parts["nodes"].append(node)
    prefix, look = f"{character.name}_", character.colour
    node["children"] = _add_body(character.clip, parts, buffer, prefix, character.name, look)
    return number


def _add_body(
    clip: Clip,
    parts: _Parts,
    buffer: Buffer,
    prefix: str,
    paint: str,
    colour: Colour,
    reduce_keys: float = 0.0,
) -> list[int]:
    """Append joints and body, named after `prefix`, of a colour; numbers of root and body."""
    first, n_joints = len(parts["nodes"]), len(clip.skeleton.names)
    name, mesh, skin = f"{prefix}body", len(parts["meshes"]), len(parts["skins"])
    parts["nodes"].extend(joint_nodes(clip, first, prefix))
    parts["nodes"].append({"name": name, "mesh": mesh, "skin": skin})
    parts["meshes"].append({**body_mesh(clip, buffer, len(parts["materials"])), "name": name})
    parts["materials"].append(material(paint, colour))
    joints = list(range(first, first + n_joints))
    parts["skins"].append({"joints": joints, "skeleton": first, **inverse_binds(clip, buffer)})
    samplers, channels = tracks(clip, buffer, first, reduce_keys)
    shift = len(parts["samplers"])
    parts["samplers"].extend(samplers)
    parts["channels"].extend(
        {**channel, "sampler": shift + number} for number, channel in enumerate(channels)
    )
    return [first, first + n_joints]


def _add_ball(ball: FloatArray, fps: float, parts: _Parts, buffer: Buffer, radius: float) -> int:
    """Append the ball; return the number of its node."""
    node = len(parts["nodes"])
    parts["nodes"].append(
        {"name": "ball", "mesh": len(parts["meshes"]), "translation": ball[0].tolist()}
    )
    points, triangles = _sphere()
    attributes = {
        "POSITION": buffer.add((radius * points).astype(np.float32), FLOAT, ARRAY),
        "NORMAL": buffer.add(points.astype(np.float32), FLOAT, ARRAY),
    }
    indices = buffer.add(triangles.reshape(-1).astype(np.uint32), UINT, ELEMENTS)
    primitive = {
        "attributes": attributes,
        "indices": indices,
        "material": len(parts["materials"]),
    }
    parts["meshes"].append({"name": "ball", "primitives": [primitive]})
    parts["materials"].append(material("ball", _BALL_COLOUR))
    times = buffer.add((np.arange(len(ball)) / fps).astype(np.float32), FLOAT)
    places = buffer.add(np.asarray(ball, dtype=np.float32), FLOAT)
    parts["channels"].append(
        {
            "sampler": len(parts["samplers"]),
            "target": {"node": node, "path": "translation"},
        }
    )
    parts["samplers"].append({"input": times, "output": places, "interpolation": "LINEAR"})
    return node


def _sphere() -> tuple[FloatArray, np.ndarray]:
    """Return points (n, 3) of the unit sphere and its triangles, counterclockwise from outside."""
    polar = np.linspace(0.0, np.pi, _RINGS + 1)
    around = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
    points = np.stack(
        [
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones_like(around)),
            np.outer(np.sin(polar), np.cos(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    ring, side = np.meshgrid(np.arange(_RINGS), np.arange(_SIDES), indexing="ij")
    corner = (ring * (_SIDES + 1) + side).reshape(-1)
    below = corner + _SIDES + 1
    upper = np.stack([corner, below, corner + 1], axis=1)
    lower = np.stack([corner + 1, below, below + 1], axis=1)
    return points, np.concatenate([upper[_SIDES:], lower[:-_SIDES]])
