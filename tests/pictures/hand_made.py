"""Motions, a scene and a symbol space made by hand for the tests of pictures."""

from __future__ import annotations

import numpy as np

from motiondb.body import body, pose_vectors, rotation
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.records import Motion, SymbolSpace

DIAGRAM = read_scene_text("give-and-go").diagram


def rest(n_frames: int, heading: float = 0.0) -> Motion:
    """A body in T-pose, pelvis at hip height, that faces a heading (degrees from +z towards +x)."""
    rotations = np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))
    if n_frames:
        rotations[:, 0] = rotation.from_euler([heading], "Y")
    height = body.LEG_LENGTH + body.ANKLE_HEIGHT
    root = np.tile([0.0, height, 0.0], (n_frames, 1))
    return Motion(rotations.astype(np.float32), root.astype(np.float32))


def swing(n_frames: int) -> Motion:
    """Arms down, swinging twice a second by 40 degrees, while the body walks along +z at 1 m/s."""
    still = rest(n_frames)
    rotations = still.local_rotations.astype(float)
    root = still.root_positions.astype(float)
    seconds = np.arange(n_frames) / 30.0
    angle = 40.0 * np.sin(4.0 * np.pi * seconds)
    for side, sign in (("l", -1.0), ("r", 1.0)):
        euler = np.stack([sign * angle, np.full(n_frames, sign * 80.0)], axis=-1)
        rotations[:, body.INDEX[f"{side}_shoulder"]] = rotation.from_euler(euler, "XZ")
    root[:, 2] = seconds
    return Motion(rotations.astype(np.float32), root.astype(np.float32))


def standing(x: float, z: float, heading: float, n_frames: int = 31, speed: float = 0.0) -> Motion:
    """Somebody in T-pose who glides from a place along a heading in radians."""
    turns = np.tile(rotation.IDENTITY, (n_frames, 21, 1))
    turns[:, 0] = pose_vectors.yaw(np.full(n_frames, heading))
    steps = speed / 30.0 * np.arange(n_frames)
    places = np.stack(
        [x + steps * np.sin(heading), np.full(n_frames, 0.93), z + steps * np.cos(heading)], axis=1
    )
    return Motion(turns.astype(np.float32), places.astype(np.float32))


def people() -> dict[str, Motion]:
    """Two players of the diagram."""
    return {"A1": standing(-3.0, 6.0, 0.5, speed=3.0), "D1": standing(3.0, 4.0, np.pi, 20)}


def space(n_symbols: int, n_dimensions: int, n_clusters: int = 2) -> SymbolSpace:
    """Symbols on a spiral, clusters in turn, Gaussians of variances 1, 4, 9."""
    turn = np.arange(n_symbols)[:, None] + np.arange(n_dimensions)
    covar = np.diag(np.arange(1.0, n_dimensions + 1.0) ** 2)
    return SymbolSpace(
        distances=np.zeros((n_symbols, n_symbols)),
        variances=np.zeros((n_symbols, n_symbols)),
        coordinates=np.cos(turn) * (1.0 + turn),
        stress=np.zeros(n_dimensions),
        clusters=np.arange(n_symbols) % n_clusters,
        weights=np.full(n_clusters, 1.0 / n_clusters),
        means=np.arange(n_clusters)[:, None] * np.ones(n_dimensions),
        covars=np.tile(covar, (n_clusters, 1, 1)),
    )
