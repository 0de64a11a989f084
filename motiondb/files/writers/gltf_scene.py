"""Writer of glTF for scenes: several characters and a ball in one world, for Blender and browsers.

Every character is a node with its joints and its body as children; the names of joints begin with
the character's name, so that they are unique. The ball is a sphere with a track of positions. All
tracks belong to one animation, so that a viewer plays the whole scene.
Source: Khronos, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.writers.gltf import (
    ARRAY,
    ELEMENTS,
    FLOAT,
    UINT,
    Buffer,
    body_mesh,
    check_clip,
    check_ending,
    inverse_binds,
    joint_nodes,
    material,
    tracks,
    write_document,
)
from motiondb.records import Clip, FloatArray

BALL_RADIUS = 0.12  # Metres; a basketball of size 7 measures 0.749 to 0.780 m round (FIBA)
_BALL_COLOUR = (0.85, 0.42, 0.13)  # Red, green and blue of a basketball, 0 to 1
_RINGS, _SIDES = 8, 16
"""Parallels and meridians of the sphere: round enough at the size of a ball, and 240 triangles."""

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Character:
    """A person in a scene."""

    name: str  # Unique in the scene
    clip: Clip  # The motion in the world frame of the scene, metres, y up
    colour: Colour = (0.35, 0.55, 0.8)  # Red, green and blue, 0 to 1


def write_gltf_scene(
    characters: Sequence[Character], path: Path | str, ball: FloatArray | None = None
) -> None:
    """Write a scene as glTF; the file is written whole or not at all.

    Shapes: `ball` (frames, 3) or None.
    """
    path = Path(path)
    check_ending(path)
    write_document(*to_gltf_scene(characters, ball, path), path)


def to_gltf_scene(
    characters: Sequence[Character], ball: FloatArray | None = None, path: object = "scene"
) -> tuple[dict[str, object], bytes]:
    """Return the JSON document of a scene, and the buffer that it describes.

    Shapes: `ball` (frames, 3) or None.
    """
    _check(characters, ball, path)
    buffer = Buffer()
    parts: dict[str, list[dict[str, object]]] = {
        key: [] for key in ("nodes", "meshes", "materials", "skins", "samplers", "channels")
    }
    roots = [_add_character(character, parts, buffer) for character in characters]
    if ball is not None and len(ball):
        roots.append(_add_ball(ball, characters[0].clip.fps, parts, buffer))
    animation = {key: parts.pop(key) for key in ("samplers", "channels")}
    document: dict[str, object] = {
        "asset": {"version": "2.0", "generator": "motiondb"},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        **parts,
        "animations": [{"name": "scene", **animation}],
        **buffer.described(),
    }
    return document, bytes(buffer.data)


def _check(characters: Sequence[Character], ball: FloatArray | None, path: object) -> None:
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
        raise CaptureError(path, "expected finite places of the ball, found NaN or infinity.")


def _add_character(
    character: Character, parts: Mapping[str, list[dict[str, object]]], buffer: Buffer
) -> int:
    """Append a character's node, joints and body; return the number of its node."""
    clip, nodes = character.clip, parts["nodes"]
    n_joints, node = len(clip.skeleton.names), len(nodes)
    first, body = node + 1, node + 1 + n_joints
    nodes.append({"name": character.name, "children": [first, body]})
    nodes.extend(joint_nodes(clip, first, f"{character.name}_"))
    nodes.append(
        {
            "name": f"{character.name}_body",
            "mesh": len(parts["meshes"]),
            "skin": len(parts["skins"]),
        }
    )
    parts["meshes"].append(
        {**body_mesh(clip, buffer, len(parts["materials"])), "name": f"{character.name}_body"}
    )
    parts["materials"].append(material(character.name, character.colour))
    parts["skins"].append(
        {
            "joints": list(range(first, first + n_joints)),
            "skeleton": first,
            **inverse_binds(clip, buffer),
        }
    )
    times = buffer.add((np.arange(clip.n_frames) / clip.fps).astype(np.float32), FLOAT)
    samplers, channels = tracks(clip, buffer, times, first)
    shift = len(parts["samplers"])
    parts["samplers"].extend(samplers)
    parts["channels"].extend(
        {**channel, "sampler": shift + number} for number, channel in enumerate(channels)
    )
    return node


def _add_ball(
    ball: FloatArray, fps: float, parts: Mapping[str, list[dict[str, object]]], buffer: Buffer
) -> int:
    """Append the ball; return the number of its node."""
    node = len(parts["nodes"])
    parts["nodes"].append(
        {"name": "ball", "mesh": len(parts["meshes"]), "translation": ball[0].tolist()}
    )
    points, triangles = _sphere()
    attributes = {
        "POSITION": buffer.add((BALL_RADIUS * points).astype(np.float32), FLOAT, ARRAY),
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
