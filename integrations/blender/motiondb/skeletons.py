"""Armatures: made from a motion, moved by one, and written as BVH for the server.

A motion is in metres with y up; Blender has z up. A motion's joint turns by D from its rest, so a
bone whose rest in the world is R stands at D R.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from .client import Array, Motion

UP = Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))  # From y up to z up
_TURN = UP.to_quaternion()
_SHORTEST = 0.01  # Length of a bone at least, metres; Blender removes bones without length
_STILL = 1e-5  # Metres that a bone may be from where its parent carries it without a key
_EVEN = 1e-3  # Ratio of scales along the axes beyond which an object is stretched
ROLES = {
    "spine": "Spine1", "chest": "Spine2", "neck": "Neck", "head": "Head",
    "l_hip": "LeftUpLeg", "l_knee": "LeftLeg", "l_ankle": "LeftFoot", "l_toe": "LeftToeBase",
    "r_hip": "RightUpLeg", "r_knee": "RightLeg", "r_ankle": "RightFoot", "r_toe": "RightToeBase",
    "l_shoulder": "LeftArm", "l_elbow": "LeftForeArm", "l_wrist": "LeftHand",
    "r_shoulder": "RightArm", "r_elbow": "RightForeArm", "r_wrist": "RightHand",
}  # fmt: skip
"""Role -> the name by which the server knows it: bones of a joint map are sent under these."""


class ArmatureError(Exception):
    """An armature that cannot be used; the message says what to do."""


def build(motion: Motion, name: str) -> bpy.types.Object:
    """Make an armature whose bones stand where the joints of a motion rest."""
    data = bpy.data.armatures.new(name)
    armature = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(armature)
    _activate(armature)
    rest = np.zeros_like(motion.offsets)
    for joint, parent in enumerate(motion.parents):
        rest[joint] = motion.offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
    places = [UP @ Vector(place) for place in rest]
    bpy.ops.object.mode_set(mode="EDIT")
    bones = []
    for joint, parent in enumerate(motion.parents):
        bone = data.edit_bones.new(motion.joints[joint])
        bone.head = places[joint]
        if parent >= 0:
            bone.parent = bones[parent]
        bones.append(bone)
    for joint, bone in enumerate(bones):
        below = [places[child] for child, above in enumerate(motion.parents) if above == joint]
        bone.tail = _tail(bone, below)
    names = [bone.name for bone in bones]
    bpy.ops.object.mode_set(mode="OBJECT")
    armature["motiondb_joints"] = names
    return armature


def _tail(bone: bpy.types.EditBone, below: list[Vector]) -> Vector:
    """Return the tail of a bone: amid its children, or onwards from its parent."""
    if below:
        tail = sum(below, Vector()) / len(below)
        if (tail - bone.head).length >= _SHORTEST:
            return tail
    onwards = bone.head - bone.parent.head if bone.parent else Vector((0.0, 0.0, 0.1))
    if onwards.length < _SHORTEST:
        onwards = Vector((0.0, 0.0, 0.1))
    return bone.head + onwards.normalized() * max(0.3 * onwards.length, _SHORTEST)


def _activate(armature: bpy.types.Object) -> None:
    """Make an object the active and only selected one, in object mode."""
    if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in bpy.context.selected_objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = armature
    armature.select_set(True)


def scale_of(armature: bpy.types.Object) -> float:
    """Return the scale of an armature (ArmatureError if it is stretched)."""
    scales = armature.matrix_world.to_scale()
    if min(scales) <= 0.0 or max(scales) / min(scales) > 1.0 + _EVEN:
        raise ArmatureError(
            f"{armature.name}: expected one scale along all axes, found "
            f"{', '.join(f'{s:.3g}' for s in scales)}. Apply it (Object > Apply > Scale)."
        )
    return sum(scales) / 3.0


def chain(armature: bpy.types.Object) -> list[bpy.types.Bone]:
    """Return the largest tree of bones, parents first and depth first, as BVH orders joints."""
    tops = [bone for bone in armature.data.bones if bone.parent is None]
    if not tops:
        raise ArmatureError(f"{armature.name}: expected bones, found none. Choose another one.")
    top = max(tops, key=lambda bone: len(bone.children_recursive))
    ordered: list[bpy.types.Bone] = []

    def walk(bone: bpy.types.Bone) -> None:
        ordered.append(bone)
        for child in bone.children:
            walk(child)

    walk(top)
    return ordered


def move(
    armature: bpy.types.Object, bones: list[str], motion: Motion, name: str, first: float
) -> bpy.types.Action:
    """Give an armature a new action: the motion, one key a frame from frame ``first`` on.

    ``bones`` are in the order of the joints. An earlier action is kept in the file.
    """
    if armature.animation_data is None:
        armature.animation_data_create()
    before = armature.animation_data.action
    if before is not None:
        before.use_fake_user = True
    action = bpy.data.actions.new(name)
    armature.animation_data.action = action
    curves = _curves(armature, action)
    posed = _pose(armature, bones, motion)
    frames = first + np.arange(len(motion.positions))
    for joint, bone_name in enumerate(bones):
        bone = armature.pose.bones[bone_name]
        at = np.array([matrix.to_translation() for matrix in posed[joint]])
        path = bone.path_from_id
        if motion.parents[joint] < 0 or np.abs(at).max() > _STILL:
            _keys(curves, path("location"), frames, at)
        if bone.rotation_mode == "AXIS_ANGLE":
            bone.rotation_mode = "QUATERNION"
        kind = "quaternion" if bone.rotation_mode == "QUATERNION" else "euler"
        turns = _turns(posed[joint], bone.rotation_mode)
        _keys(curves, path(f"rotation_{kind}"), frames, turns)
    return action


def _pose(armature: bpy.types.Object, bones: list[str], motion: Motion) -> list[list[Matrix]]:
    """Return for each joint and frame the transform of its bone beside its rest."""
    world = armature.matrix_world
    back, turn = world.inverted(), world.to_quaternion()
    rests = [armature.data.bones[bone] for bone in bones]
    own = [bone.matrix_local.to_quaternion() for bone in rests]
    posed: list[list[Matrix]] = [[] for _ in bones]
    for places, locals_ in zip(motion.positions, motion.local_rotations):
        turned: list[Quaternion] = []
        stand: list[Matrix] = []
        for joint, parent in enumerate(motion.parents):
            here = Quaternion(locals_[joint])
            here = turned[parent] @ here if parent >= 0 else here
            turned.append(here)
            by = turn.conjugated() @ _TURN @ here @ _TURN.conjugated() @ turn
            matrix = Matrix.Translation(back @ (UP @ Vector(places[joint])))
            stand.append(matrix @ (by @ own[joint]).to_matrix().to_4x4())
            bone = rests[joint]
            above = (
                {"parent_matrix": stand[parent], "parent_matrix_local": rests[parent].matrix_local}
                if parent >= 0
                else {}
            )
            posed[joint].append(
                bone.convert_local_to_pose(stand[joint], bone.matrix_local, **above, invert=True)
            )
    return posed


def _turns(matrices: list[Matrix], mode: str) -> Array:
    """Return the rotations as keys of a bone's rotation mode, without jumps."""
    turns: list[list[float]] = []
    before = None
    for matrix in matrices:
        if mode == "QUATERNION":
            found = matrix.to_quaternion()
            if before is not None and found.dot(before) < 0.0:
                found.negate()
        else:
            found = matrix.to_euler(mode) if before is None else matrix.to_euler(mode, before)
        before = found
        turns.append(list(found))
    return np.array(turns)


def _curves(armature: bpy.types.Object, action: bpy.types.Action) -> bpy.types.bpy_prop_collection:
    """Return the curves of a new action; since Blender 4.4 they lie in a slot's channelbag."""
    if not hasattr(action, "slots"):
        return action.fcurves
    slot = action.slots.new(id_type="OBJECT", name=armature.name)
    armature.animation_data.action_slot = slot
    strip = action.layers.new("Layer").strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True).fcurves


def _keys(curves: bpy.types.bpy_prop_collection, path: str, frames: Array, values: Array) -> None:
    """Add a curve for each column of values (frames, columns), straight between keys."""
    kinds = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items
    for index, column in enumerate(values.T):
        curve = curves.new(path, index=index)
        curve.keyframe_points.add(len(frames))
        curve.keyframe_points.foreach_set("co", np.stack([frames, column], axis=1).ravel())
        straight = [kinds["LINEAR"].value] * len(frames)
        curve.keyframe_points.foreach_set("interpolation", straight)
        curve.update()


def to_bvh(
    armature: bpy.types.Object, roles: dict[str, str], frames: range | None = None
) -> tuple[str, list[str]]:
    """Return an armature as BVH in centimetres with y up, and its bones in that order.

    ``roles`` is a joint map (role -> bone). Without frames it has one, the rest pose.
    """
    scale = 100.0 * scale_of(armature)
    bones = chain(armature)
    number = {bone.name: joint for joint, bone in enumerate(bones)}
    sent = {bone: ROLES[role] for role, bone in roles.items() if role in ROLES}
    turn = UP.transposed() @ armature.matrix_world.to_quaternion().to_matrix()
    lines = ["HIERARCHY"]

    def offset(vector: Vector) -> str:
        return "OFFSET " + " ".join(f"{scale * value:.6f}" for value in turn @ vector)

    def write(bone: bpy.types.Bone, depth: int) -> None:
        pad = "  " * depth
        label = "_".join(bone.name.split())
        if sent:
            label = sent.get(bone.name, f"other_{number[bone.name]}")
        above = bone.parent
        place = bone.head_local - above.head_local if above else Vector()
        channels = "" if above else "Xposition Yposition Zposition "
        lines.extend(
            [
                f"{pad}{'JOINT' if above else 'ROOT'} {label}",
                f"{pad}{{",
                f"{pad}  {offset(place)}",
                f"{pad}  CHANNELS {3 if above else 6} {channels}Zrotation Xrotation Yrotation",
            ]
        )
        for child in bone.children:
            write(child, depth + 1)
        if not bone.children:
            end = offset(bone.tail_local - bone.head_local)
            lines.extend([f"{pad}  End Site", f"{pad}  {{", f"{pad}    {end}", f"{pad}  }}"])
        lines.append(f"{pad}}}")

    write(bones[0], 0)
    rows = _rest_row(armature, bones) if frames is None else _rows(armature, bones, frames)
    seconds = 1.0 / fps_of(bpy.context.scene)
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {seconds:.9f}", *rows]
    return "\n".join(lines) + "\n", [bone.name for bone in bones]


def _rest_row(armature: bpy.types.Object, bones: list[bpy.types.Bone]) -> list[str]:
    """Return the only frame of a rig: where its root rests, without rotations."""
    place = UP.transposed() @ (armature.matrix_world @ bones[0].head_local) * 100.0
    return [" ".join(f"{value:.6f}" for value in [*place, *[0.0] * 3 * len(bones)])]


def _rows(armature: bpy.types.Object, bones: list[bpy.types.Bone], frames: range) -> list[str]:
    """Return the frames of an animated armature; the scene's frame stays."""
    scene, rows = bpy.context.scene, []
    kept = scene.frame_current
    try:
        for frame in frames:
            scene.frame_set(frame)
            world = armature.matrix_world
            turn, turned = world.to_quaternion(), dict[str, Quaternion]()
            top = armature.pose.bones[bones[0].name]
            values = list(UP.transposed() @ (world @ top.head) * 100.0)
            for bone in bones:
                posed = armature.pose.bones[bone.name].matrix.to_quaternion()
                by = turn @ posed @ bone.matrix_local.to_quaternion().conjugated()
                by = _TURN.conjugated() @ by @ turn.conjugated() @ _TURN
                turned[bone.name] = by
                here = turned[bone.parent.name].conjugated() @ by if bone.parent else by
                # Z X Y: the first rotation of the file is the outermost
                angles = here.to_euler("YXZ")
                values += [np.degrees(angles[axis]) for axis in (2, 0, 1)]
            rows.append(" ".join(f"{value:.6f}" for value in values))
    finally:
        scene.frame_set(kept)
    return rows


def fps_of(scene: bpy.types.Scene) -> float:
    """Return the frame rate of a scene."""
    return float(scene.render.fps / scene.render.fps_base)


def set_fps(scene: bpy.types.Scene, fps: float) -> None:
    """Set the frame rate of a scene, which Blender holds as a whole number by a base."""
    scene.render.fps = max(1, round(fps))
    scene.render.fps_base = scene.render.fps / fps
