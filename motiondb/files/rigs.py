"""Rigs: skeletons of others, onto which motion is put. A rig is a clip of one frame, its pose.

BVH: the pose without rotations; where nobody could stand so, that of the first frame (in files of
Bandai-Namco all bones lie along one axis without rotations, in some of CMU the legs point up).
MJCF and URDF: the pose in which all hinges are 0. FBX: the pose in which the joints stand in the
file, of the person with the most joints. glTF: that of the nodes; the joints are those of the first
skin, or of the animated nodes where there is none. Meshes are not read.

Rigs of this program with the joints of LAFAN1, SOMA, Mixamo and SMPL.

The names and the hierarchy are those of the programs; the proportions are those of the canonical
body, in T-pose, y up, facing +z. SOMA's is without fingers and face.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from motiondb.body import body, changes, hinges, kinematics, retarget, rotation
from motiondb.body.hinges import Robot
from motiondb.body.joint_names import REQUIRED, joint_map
from motiondb.body.joint_proposals import map_text, propose_map
from motiondb.errors import CaptureError, SkeletonError
from motiondb.files.formats import read_capture_bytes, read_file, read_skeleton
from motiondb.files.json_text import parse_json
from motiondb.files.limits import AS_USUAL, guarded
from motiondb.files.readers.amass import skeleton as smpl_skeleton
from motiondb.files.readers.first_bytes import MODEL_ENDINGS
from motiondb.files.readers.robot_model import read_robot
from motiondb.files.safe_files import write_bytes
from motiondb.records import Clip, FloatArray, Skeleton

ENDINGS = (".bvh", ".fbx", ".glb", ".gltf", *MODEL_ENDINGS)  # Of files that hold a rig
_ALIKE = 0.8  # Cosine of the angle between directions that count as alike. By hand
_MOST_JSON = 100_000_000  # Bytes of the document of a glTF file


def read_rig(path: Path | str, user_map: Mapping[str, str] | None = None) -> Clip:
    """Read the rig in a file (CaptureError); `user_map`: role -> joint."""
    path = Path(path)
    ending = path.suffix.lower()
    if str(path) in OWN_RIGS and not path.exists():
        return own_rig(str(path))
    if ending not in ENDINGS:
        known = ", ".join(ENDINGS)
        raise CaptureError(
            path, f"expected a rig ({known}, or {', '.join(OWN_RIGS)}), found ending {ending!r}."
        )
    if ending in MODEL_ENDINGS:
        robot = read_model(path)
        return replace(hinges.to_clip(robot, hinges.at_zero(robot), 30.0), unit=1.0)
    data = read_file(path, AS_USUAL)
    if ending == ".bvh":
        clip = read_capture_bytes(data, "bvh", path=path)
        still = np.tile(rotation.IDENTITY, (1, len(clip.skeleton.names), 1))
        pose = replace(
            clip, local_rotations=still, root_positions=np.zeros((1, 3)), joint_positions=None
        )
        return pose if _stands(pose, user_map) else changes.part(clip, 0, 1)
    with guarded(path):
        if ending == ".fbx":
            from motiondb.files.readers.fbx import read_pose

            return read_pose(data, path)
        return _read_gltf(data, path)


def read_model(path: Path) -> Robot:
    """Read the robot in an MJCF or URDF file (CaptureError)."""
    with guarded(path):
        robot = read_robot(read_skeleton(path, AS_USUAL), path)
        return replace(robot, name=path.name)


def _stands(pose: Clip, user_map: Mapping[str, str] | None) -> bool:
    """Whether a person could stand so: the trunk against the legs, hips along the shoulders."""
    try:
        at = retarget.clip_keypoints(pose, user_map)[0]
    except SkeletonError:  # unknown names, which are refused later
        return True
    joint = {name: at[number] for name, number in body.INDEX.items()}
    trunk = _unit(joint["neck"] - joint["pelvis"])
    legs = _unit(joint["l_ankle"] + joint["r_ankle"] - 2.0 * joint["pelvis"])
    hips, shoulders = (_unit(joint[f"l_{on}"] - joint[f"r_{on}"]) for on in ("hip", "shoulder"))
    return bool(trunk @ legs < -_ALIKE and hips @ shoulders > _ALIKE)


def _unit(way: FloatArray) -> FloatArray:
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9))


def _read_gltf(data: bytes, path: Path) -> Clip:
    """Read the joints of a glTF file."""
    document = _document(data, path)
    nodes = document.get("nodes", []) if isinstance(document, dict) else []
    skins = document.get("skins", []) if isinstance(document, dict) else []
    _check_nodes(nodes, skins, path)
    if skins:
        chosen = {int(joint) for joint in skins[0].get("joints", [])}
    else:
        chosen = {number for number, node in enumerate(nodes) if "mesh" not in node}
    parents = {int(child): n for n, node in enumerate(nodes) for child in node.get("children", [])}
    if len(chosen) < 2 or not chosen <= set(range(len(nodes))):
        raise CaptureError(
            path, "expected a skin with joints, found none. Export the skeleton with the file."
        )
    matrices: dict[int, FloatArray] = {}
    order: list[int] = []
    for number in sorted(chosen):
        chain = [number]
        while chain[-1] in parents and parents[chain[-1]] not in matrices:
            chain.append(parents[chain[-1]])
            if len(chain) > len(nodes):
                raise CaptureError(path, "expected a tree of nodes, found a circle.")
        for node in reversed(chain):
            if node not in matrices:
                own = _matrix(nodes[node])
                above = matrices.get(parents.get(node, -1), np.eye(4))
                matrices[node] = above @ own
                order += [node] if node in chosen else []
    return _clip(nodes, parents, order, matrices, path)


_LENGTHS = {"matrix": 16, "rotation": 4, "scale": 3, "translation": 3}  # Of a node's properties


def _check_nodes(nodes: Any, skins: Any, path: Path) -> None:  # noqa: ANN401  JSON of any shape
    """Refuse nodes and skins of another form than glTF gives them (CaptureError)."""
    faults = []
    for what, listed in (("nodes", nodes), ("skins", skins)):
        if not isinstance(listed, list) or not all(isinstance(one, dict) for one in listed):
            raise CaptureError(path, f"expected {what} as a list of objects, found other JSON.")
    for number, node in enumerate(nodes):
        for key, length in _LENGTHS.items():
            values = node.get(key, [0] * length)
            if not _are_numbers(values, int | float) or len(values) != length:
                faults.append(f"node {number}: expected {length} numbers as {key}, found others")
        if not _are_numbers(node.get("children", []), int):
            faults.append(f"node {number}: expected numbers of nodes as children, found others")
    if any(not _are_numbers(skin.get("joints", []), int) for skin in skins):
        faults.append("skin: expected numbers of nodes as joints, found others")
    if faults:
        raise CaptureError(path, [(None, f"{fault}. Export it again.") for fault in faults[:5]])


def _are_numbers(values: Any, kind: Any) -> bool:  # noqa: ANN401  JSON of any shape
    """Whether a value is a list of numbers of a kind."""
    return isinstance(values, list) and all(isinstance(value, kind) for value in values)


def _clip(
    nodes: list[Any],
    parents: dict[int, int],
    order: list[int],
    matrices: dict[int, FloatArray],
    path: Path,
) -> Clip:
    """Return the pose of joints, given in an order in which parents come before children."""
    number = {node: joint for joint, node in enumerate(order)}
    above = []
    for node in order:
        parent = parents.get(node, -1)
        while parent >= 0 and parent not in number:
            parent = parents.get(parent, -1)
        above.append(number.get(parent, -1))
    if above.count(-1) != 1:
        raise CaptureError(path, f"expected one skeleton, found {above.count(-1)}. Export one.")
    places = np.array([matrices[node][:3, 3] for node in order])
    turns = np.array([_turn(matrices[node][:3, :3]) for node in order])
    local, (offsets,) = kinematics.to_local(np.array(above), places[None], turns[None])
    offsets[0] = 0.0
    names = tuple(str(nodes[node].get("name", f"joint{node}")) for node in order)
    skeleton = Skeleton(names, np.array(above), offsets)
    return Clip(skeleton, 30.0, local, places[None, 0], format="gltf", unit=1.0)


def _document(data: bytes, path: Path) -> Any:  # noqa: ANN401  JSON of any shape
    """Return the JSON document of a glTF file in either form."""
    text = data
    if data[:4] == b"glTF":
        length = int.from_bytes(data[12:16], "little")
        text = data[20 : 20 + length]
        if data[16:20] != b"JSON" or len(text) < length:
            raise CaptureError(path, "expected a whole glTF file, found one that is cut short.")
    try:
        return parse_json(text, _MOST_JSON)
    except ValueError as error:
        raise CaptureError(path, f"{error}. Export it again.") from None


def _matrix(node: Any) -> FloatArray:  # noqa: ANN401  JSON of any shape
    """Return the transform (4, 4) of a node."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    matrix = np.eye(4)
    turn = rotation.to_matrix(rotation.normalize(np.array([w, x, y, z], dtype=float)))
    matrix[:3, :3] = turn * np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=float)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _turn(linear: FloatArray) -> FloatArray:
    """Return the rotation of a matrix (3, 3) with a scale."""
    return rotation.from_matrix(rotation.normalize(linear.T).T)


@dataclass(frozen=True)
class JointProposal:
    """Which joints of a file have which roles."""

    file: str
    joints: int
    is_known: bool  # Whether a convention names the joints; otherwise the roles are proposed
    roles: dict[str, str]  # Role -> joint
    missing: tuple[str, ...]  # Needed roles for which no joint is found
    map: str | None  # Joint map that was written


def propose_joints(
    of: Path | str | Clip, output: Path | None = None, name: str = ""
) -> JointProposal:
    """Say which joints of a file or a clip have which roles, and write a joint map.

    Parameters
    ----------
    of : Path, str or Clip
        A file with a rig or a capture (.bvh, .fbx, .glb or .gltf), or a clip.
    output : Path or None
        Joint map to write, with the roles and a list of all joints.
    name : str
        What to call it; the name of the file if not given.

    Returns
    -------
    JointProposal
        The roles, proposed where no convention names the joints.

    Raises
    ------
    CaptureError
        When the file cannot be read.
    """
    skeleton = (of if isinstance(of, Clip) else read_rig(of)).skeleton
    name = name or ("clip" if isinstance(of, Clip) else str(of))
    try:
        joint_map(skeleton)
        is_known = True
    except SkeletonError:
        is_known = False
    roles = propose_map(skeleton)
    if output is not None:
        write_bytes(output, map_text(skeleton, Path(name).name).encode())
    missing = () if is_known else tuple(role for role in REQUIRED if role not in roles)
    return JointProposal(
        name,
        len(skeleton.names),
        is_known,
        roles,
        missing,
        None if output is None else str(output),
    )


_TRUNK = {
    "lafan1": "Hips=pelvis Spine=.25 Spine1=.5 Spine2=.75 Neck=neck Head=head",
    "mixamo": "Hips=pelvis Spine=.25 Spine1=.5 Spine2=.75 Neck=neck Head=head",
    "soma": "Hips=pelvis Spine1=.25 Spine2=.5 Chest=.75 Neck1=neck Neck2=1.1 Head=head",
}  # Joint = role, or share of the way from the pelvis to the neck; each hangs from the one before
_LIMBS = {
    "lafan1": ("UpLeg Leg Foot Toe", "Shoulder Arm ForeArm Hand"),
    "mixamo": ("UpLeg Leg Foot ToeBase", "Shoulder Arm ForeArm Hand"),
    "soma": ("Leg Shin Foot ToeBase", "Shoulder Arm ForeArm Hand"),
}
_ROLES = (("hip", "knee", "ankle", "toe"), ("collar", "shoulder", "elbow", "wrist"))
_PREFIX: Mapping[str, str] = MappingProxyType({"mixamo": "mixamorig:"})
OWN_RIGS = ("lafan1", "soma", "mixamo", "smpl")
"""Names of the rigs."""


def own_rig(name: str) -> Clip:
    """Return a rig of this program in T-pose, one of ``OWN_RIGS``.

    >>> own_rig("mixamo").joint_names[:3], len(own_rig("smpl").joint_names)
    (('mixamorig:Hips', 'mixamorig:Spine', 'mixamorig:Spine1'), 22)
    """
    skeleton = smpl_skeleton() if name == "smpl" else _skeleton(name)
    still = np.tile(rotation.IDENTITY, (1, len(skeleton.names), 1))
    height = body.LEG_LENGTH + body.ANKLE_HEIGHT
    return Clip(
        skeleton, 30.0, still, np.array([[0.0, height, 0.0]]), unit=0.01, up="y", format="bvh"
    )


def _skeleton(name: str) -> Skeleton:
    at = _places()
    names, parents, places = list[str](), list[int](), list[FloatArray]()
    ends: list[tuple[int, tuple[float, float, float]]] = []

    def add(joint: str, parent: int, place: FloatArray, role: str) -> int:
        names.append(_PREFIX.get(name, "") + joint)
        parents.append(parent)
        places.append(place)
        for number, offset in body.END_SITES:
            if body.JOINTS[number] == role:
                ends.append((len(names) - 1, offset))
        return len(names) - 1

    joint, trunk = -1, list[int]()
    for entry in _TRUNK[name].split():
        label, _, role = entry.partition("=")
        share = float(role) if role not in at else 0.0
        place = at[role] if role in at else at["pelvis"] + share * (at["neck"] - at["pelvis"])
        joint = add(label, joint, place, role)
        trunk.append(joint)
    chest = trunk[3]
    for limb, roles, start in zip(_LIMBS[name], _ROLES, (trunk[0], chest)):
        for side in ("Left", "Right"):
            joint = start
            for part, role in zip(limb.split(), roles):
                of_side = f"{side[0].lower()}_{role}"
                joint = add(side + part, joint, at[of_side], of_side)
    above = np.array(parents)
    where = np.array(places)
    offsets = np.where(above[:, None] >= 0, where - where[above.clip(0)], 0.0)
    return Skeleton(tuple(names), above, offsets, tuple(ends))


def _places() -> dict[str, FloatArray]:
    """Return where the joints of the canonical body are in its rest pose."""
    at: dict[str, FloatArray] = {}
    for number, joint in enumerate(body.JOINTS):
        parent = int(body.PARENTS[number])
        above = at[body.JOINTS[parent]] if parent >= 0 else np.zeros(3)
        at[joint] = above + body.OFFSETS[number]
    return at
