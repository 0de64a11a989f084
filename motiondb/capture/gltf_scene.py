"""Several characters and a ball in one glTF, in one world and one time, for Blender and browsers.

Every character is a node with the joints and the body below it; names of joints carry the
character's, so that each is found by its own. The ball is a sphere with a track of places. All
tracks belong to one animation, so that a viewer plays the scene at once.
Source: Khronos, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.capture.gltf import (
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
from motiondb.errors import CaptureError
from motiondb.records import Clip, FloatArray

BALL_RADIUS = 0.12
"""Metres; a basketball of size 7 measures 0.749 to 0.780 m round (FIBA)."""
_BALL_COLOUR = (0.85, 0.42, 0.13)
_RINGS, _SIDES = 8, 16
"""Of the sphere: parallels and meridians."""

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Character:
    """Somebody in a scene: a name, a motion in the scene's world, a colour (0 to 1)."""

    name: str
    clip: Clip
    colour: Colour = (0.35, 0.55, 0.8)


def write_gltf_scene(
    characters: Sequence[Character], path: Path | str, ball: FloatArray | None = None
) -> None:
    """Write a scene as glTF; the ending chooses the form. The file appears whole or not at all.

    Parameters
    ----------
    ball : array (frames, 3), metres, at the rate of the first character; None: there is none.

    Raises
    ------
    CaptureError
        for other endings than .glb and .gltf, a scene without characters or two of one name, clips
        without frames, numbers that are not finite, or a file that cannot be written.
    """
    path = Path(path)
    check_ending(path)
    write_document(*to_gltf_scene(characters, ball, path), path)


def to_gltf_scene(
    characters: Sequence[Character], ball: FloatArray | None = None, path: object = "scene"
) -> tuple[dict[str, object], bytes]:
    """The JSON document of a scene and the buffer it describes."""
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
    """Append a character's node, joints and body; gives the number of the node."""
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
    """Append the ball; gives the number of its node."""
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
    """Points of the unit sphere and its triangles, seen from outside against the clock."""
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
