"""A small person as a model of OpenSim 3 and of 4, made from one table, and a walk of it."""

from __future__ import annotations

import math
from collections.abc import Mapping

_SIDE = (
    # body, parent, place in the parent (of the right side, z > 0), kind, axes of its coordinates
    ("femur", "pelvis", (-0.07, -0.06, 0.08), "Custom", {"hip_flexion": "z", "hip_adduction": "x"}),
    ("tibia", "femur", (0.0, -0.4, 0.0), "Custom", {"knee_angle": "z"}),
    ("talus", "tibia", (0.0, -0.4, 0.0), "Pin", {"ankle_angle": "z"}),
    ("toes", "talus", (0.13, -0.04, 0.0), "Weld", {}),
    ("humerus", "torso", (0.0, 0.37, 0.17), "Ball", {"arm_x": "x", "arm_y": "y", "arm_z": "z"}),
    ("ulna", "humerus", (0.0, -0.28, 0.0), "Pin", {"elbow_flex": "z"}),
    ("hand", "ulna", (0.0, -0.25, 0.0), "Weld", {}),
)
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
_ROOT = {"pelvis_tilt": "z", "pelvis_list": "x", "pelvis_rotation": "y"}
_WAYS = {"pelvis_tx": "x", "pelvis_ty": "y", "pelvis_tz": "z"}
KNEE_X, KNEE_Y = (0.0, 1.0, 2.0), (0.0, -0.01, -0.04)
"""The knee glides along x by this spline of its angle."""

Rows = list[tuple[str, str, tuple[float, ...], str, Mapping[str, str]]]


def _rows(with_arms: bool) -> Rows:
    rows: Rows = [
        ("pelvis", "ground", (0.0, 0.0, 0.0), "Custom", _ROOT),
        ("torso", "pelvis", (-0.1, 0.08, 0.0), "Custom", {"lumbar_extension": "z"}),
    ]
    for side, sign in (("r", 1.0), ("l", -1.0)):
        for body, parent, (x, y, z), kind, axes in _SIDE:
            if with_arms or body not in ("humerus", "ulna", "hand"):
                above = parent if parent in ("pelvis", "torso") else f"{parent}_{side}"
                named = {f"{name}_{side}": axis for name, axis in axes.items()}
                rows.append((f"{body}_{side}", above, (x, y, sign * z), kind, named))
    return rows


def _axis(name: str, coordinate: str, direction: str, function: str) -> str:
    return (
        f'<TransformAxis name="{name}"><coordinates>{coordinate}</coordinates>'
        f"<axis>{direction}</axis>{function}</TransformAxis>"
    )


def _transform(body: str, axes: Mapping[str, str], is_old: bool) -> str:
    wrap = ("<function>", "</function>") if is_old else ("", "")
    line = f"{wrap[0]}<LinearFunction><coefficients>1 0</coefficients></LinearFunction>{wrap[1]}"
    still = f"{wrap[0]}<Constant><value>0</value></Constant>{wrap[1]}"
    turns = [(name, _AXES[axis], line) for name, axis in axes.items()]
    turns += [("", _AXES[a], still) for a in "xyz" if a not in axes.values()]
    ways = [("", _AXES[axis], still) for axis in "xyz"]
    if body == "pelvis":
        ways = [(name, _AXES[axis], line) for name, axis in _WAYS.items()]
    if body.startswith("tibia"):
        x, y = (" ".join(map(str, values)) for values in (KNEE_X, KNEE_Y))
        spline = f"{wrap[0]}<SimmSpline><x>{x}</x><y>{y}</y></SimmSpline>{wrap[1]}"
        ways[0] = (next(iter(axes)), _AXES["x"], spline)
    kinds = [f"{kind}{n}" for kind in ("rotation", "translation") for n in (1, 2, 3)]
    content = "".join(_axis(kind, *axis) for kind, axis in zip(kinds, turns + ways))
    return f"<SpatialTransform>{content}</SpatialTransform>"


def osim(version: int = 4, with_arms: bool = True, gravity: str = "0 -9.8 0") -> str:
    """The model as OpenSim 3 or 4 writes it."""
    is_old = version < 4
    bodies, joints = [], []
    for body, parent, place, kind, axes in _rows(with_arms):
        names = [*axes, *(_WAYS if body == "pelvis" else ())]
        coordinates = "".join(f'<Coordinate name="{name}"/>' for name in names)
        transform = _transform(body, axes, is_old) if kind == "Custom" else ""
        at = " ".join(map(str, place))
        if is_old:
            joint = (
                f'<{kind}Joint name="j_{body}"><parent_body>{parent}</parent_body>'
                f"<location_in_parent>{at}</location_in_parent><location>0 0 0</location>"
                f"<CoordinateSet><objects>{coordinates}</objects></CoordinateSet>{transform}"
                f"</{kind}Joint>"
            )
            bodies.append(f'<Body name="{body}"><Joint>{joint}</Joint></Body>')
            continue
        above = "/ground" if parent == "ground" else f"/bodyset/{parent}"
        bodies.append(f'<Body name="{body}"/>')
        joints.append(
            f'<{kind}Joint name="j_{body}"><socket_parent_frame>offset</socket_parent_frame>'
            f"<socket_child_frame>/bodyset/{body}</socket_child_frame>"
            f"<coordinates>{coordinates}</coordinates><frames>"
            f'<PhysicalOffsetFrame name="offset"><socket_parent>{above}</socket_parent>'
            f"<translation>{at}</translation><orientation>0 0 0</orientation>"
            f"</PhysicalOffsetFrame></frames>{transform}</{kind}Joint>"
        )
    ground = '<Body name="ground"><Joint/></Body>' if is_old else ""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><OpenSimDocument Version="{version}0000">'
        f'<Model name="small"><gravity>{gravity}</gravity>'
        f"<BodySet><objects>{ground}{''.join(bodies)}</objects></BodySet>"
        f"<JointSet><objects>{''.join(joints)}</objects></JointSet></Model></OpenSimDocument>"
    )


def walk(frames: int = 60, fps: float = 60.0) -> dict[str, list[float]]:
    """Values of some coordinates, radians and metres, and the time."""
    t = [frame / fps for frame in range(frames)]
    swing = [0.4 * math.sin(2.0 * math.pi * at) for at in t]
    return {
        "time": t,
        "pelvis_tilt": [0.05] * frames,
        "pelvis_tx": [1.2 * at for at in t],
        "pelvis_ty": [0.93] * frames,
        "hip_flexion_r": swing,
        "hip_flexion_l": [-value for value in swing],
        "knee_angle_r": [-0.3 - 0.3 * math.cos(2.0 * math.pi * at) for at in t],
        "elbow_flex_r": [0.5] * frames,
    }


def mot(
    values: Mapping[str, list[float]],
    header: str = "Coordinates\nversion=1\nnRows={rows}\nnColumns={columns}\ninDegrees=yes\n\n"
    "Units are S.I. units (second, meters, Newtons, ...)\n\nendheader\n",
    degrees: bool = True,
    spelt: str = "{}",
) -> str:
    """The walk as text; `spelt`: how names of coordinates are written."""
    names = list(values)

    def number(name: str, row: int) -> str:
        is_angle = degrees and name != "time" and not name.startswith("pelvis_t")
        is_angle |= degrees and name == "pelvis_tilt"
        value = values[name][row]
        return f"{math.degrees(value) if is_angle else value:.9f}"

    rows = range(len(values["time"]))
    head = header.format(rows=len(rows), columns=len(names))
    titles = "\t".join(name if name == "time" else spelt.format(name) for name in names)
    body = "".join("\t".join(number(name, row) for name in names) + "\n" for row in rows)
    return f"{head}{titles}\n{body}"
