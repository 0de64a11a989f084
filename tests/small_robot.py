"""A small humanoid robot as MJCF and as URDF, made from one table, and a walk of it."""

from __future__ import annotations

import math

import numpy as np

from motiondb.records import FloatArray

_SIDE = (
    # link, parent, place (y of the left side), axis of its hinge ("" fixed), degrees allowed
    ("hip_pitch", "pelvis", (0.0, 0.06, -0.1), "y", (-140, 140)),
    ("hip_roll", "hip_pitch", (0.0, 0.05, -0.03), "x", (-30, 90)),
    ("hip_yaw", "hip_roll", (0.0, 0.0, -0.1), "z", (-150, 150)),
    ("knee", "hip_yaw", (0.0, 0.0, -0.2), "y", (-5, 160)),
    ("ankle_pitch", "knee", (0.0, 0.0, -0.3), "y", (-50, 40)),
    ("ankle_roll", "ankle_pitch", (0.0, 0.0, -0.02), "x", (-20, 20)),
    ("shoulder_pitch", "torso", (0.0, 0.12, 0.3), "y", (-170, 170)),
    ("shoulder_roll", "shoulder_pitch", (0.0, 0.04, 0.0), "x", (-90, 130)),
    ("shoulder_yaw", "shoulder_roll", (0.0, 0.0, -0.1), "z", (-150, 150)),
    ("elbow", "shoulder_yaw", (0.0, 0.0, -0.1), "y", (-150, 10)),
    ("hand", "elbow", (0.02, 0.0, -0.18), "", (0, 0)),
)
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def _rows() -> list[tuple[str, str, tuple[float, float, float], str, tuple[float, float]]]:
    rows = [
        ("pelvis", "", (0.0, 0.0, 0.0), "", (0.0, 0.0)),
        ("torso", "pelvis", (0.0, 0.0, 0.1), "z", (-150.0, 150.0)),
    ]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for link, parent, (x, y, z), axis, (low, high) in _SIDE:
            above = parent if parent in ("pelvis", "torso") else f"{side}_{parent}"
            limits = (-high, -low) if axis == "x" and sign < 0 else (low, high)
            rows.append((f"{side}_{link}", above, (x, sign * y, z), axis, limits))
    return rows


JOINTS = tuple(f"{link}_joint" for link, _, _, axis, _ in _rows() if axis)
"""Names of the 21 hinges: that of the waist, and left before right."""


def mjcf() -> str:
    """The robot as MJCF: angles in degrees, the axis y by a default class."""
    rows = _rows()

    def body(link: str) -> str:
        _, _, place, axis, (low, high) = next(row for row in rows if row[0] == link)
        joint = "<freejoint/>" if link == "pelvis" else ""
        if axis:
            about = "" if axis == "y" else f'axis="{_AXES[axis]}" '
            joint = f'<joint name="{link}_joint" {about}range="{low} {high}"/>'
        inner = "".join(body(row[0]) for row in rows if row[1] == link)
        at = " ".join(map(str, place))
        return f'<body name="{link}" pos="{at}">{joint}<geom size=".01"/>{inner}</body>'

    return (
        '<mujoco model="small"><compiler autolimits="true"/>'
        '<default><default class="robot"><joint axis="0 1 0"/></default></default>'
        '<worldbody><geom name="floor"/>'
        + body("pelvis").replace("<body ", '<body childclass="robot" ', 1)
        + "</worldbody></mujoco>"
    )


def urdf() -> str:
    """The same robot as URDF."""
    text = '<?xml version="1.0"?><robot name="small">'
    for link, above, place, axis, (low, high) in _rows():
        text += f'<link name="{link}"/>'
        if not above:
            continue
        kind = "revolute" if axis else "fixed"
        text += (
            f'<joint name="{link}_joint" type="{kind}"><parent link="{above}"/>'
            f'<child link="{link}"/><origin xyz="{" ".join(map(str, place))}" rpy="0 0 0"/>'
        )
        if axis:
            text += f'<axis xyz="{_AXES[axis]}"/>'
            text += f'<limit lower="{math.radians(low)}" upper="{math.radians(high)}"/>'
        text += "</joint>"
    return text + "</robot>"


def walk(n_frames: int = 120, fps: float = 30.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Root (frames, 3), its quaternions w x y z (frames, 4), and values (frames, 21) of a walk."""
    time = np.arange(n_frames) / fps
    swing = np.sin(2.0 * np.pi * time)
    values = np.zeros((n_frames, len(JOINTS)))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for joint, value in (
            ("hip_pitch", -0.3 * sign * swing - 0.15),
            ("knee", 0.35 + 0.3 * np.clip(sign * np.roll(swing, 4), 0.0, 1.0)),
            ("ankle_pitch", -0.2 + 0.1 * sign * swing),
            ("shoulder_pitch", 0.4 * sign * swing),
            ("shoulder_roll", np.full(n_frames, 0.15 * sign)),
            ("elbow", np.full(n_frames, -0.7)),
        ):
            values[:, JOINTS.index(f"{side}_{joint}_joint")] = value
    values[:, JOINTS.index("torso_joint")] = 0.1 * swing
    root = np.stack([0.8 * time, 0.1 * time, np.full(n_frames, 0.74) + 0.01 * swing**2], axis=-1)
    half = 0.1 * time
    zero = np.zeros(n_frames)
    return root, np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1), values
