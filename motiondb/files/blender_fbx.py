"""Work of Blender: turn a BVH file into FBX. Run by :mod:`.fbx_writer`, in Blender's Python.

It imports nothing of motiondb, which Blender does not have. Joints are called j0, j1, ... in the
BVH file, because Blender changes some names as it reads them; the true ones come through the
standard input.
"""

from __future__ import annotations

import json
import sys
from typing import Any


def convert(bvh: str, fbx: str) -> None:
    """Read a BVH file in metres, name its bones, and write FBX."""
    import bpy  # noqa: I001  it brings addon_utils
    import addon_utils

    bpy.ops.wm.read_factory_settings(use_empty=True)
    for addon in ("io_anim_bvh", "io_scene_fbx"):
        addon_utils.enable(addon)
    bpy.ops.import_anim.bvh(
        filepath=bvh,
        global_scale=1.0,
        update_scene_fps=True,
        update_scene_duration=True,
        rotate_mode="QUATERNION",
    )
    armature = bpy.context.object
    said = json.load(sys.stdin)
    for number, name in enumerate(said["joints"]):
        armature.data.bones[f"j{number}"].name = name
    armature.name = armature.data.name = said["armature"]
    for curve in _curves(armature.animation_data.action):  # the importer begins at 1 at least
        for key in curve.keyframe_points:
            for point in (key.co, key.handle_left, key.handle_right):
                point.x -= 1.0
    scene = bpy.context.scene
    scene.name, scene.frame_start, scene.frame_end = said["take"], 0, said["frames"] - 1
    bpy.ops.export_scene.fbx(
        filepath=fbx,
        object_types={"ARMATURE"},
        add_leaf_bones=said["leaves"],
        bake_anim=True,
        bake_anim_use_nla_strips=False,
        bake_anim_use_all_actions=False,
        bake_anim_simplify_factor=0.0,
    )


def _curves(action: Any) -> Any:  # noqa: ANN401  types of Blender
    """Return the curves of an action, whose place depends on the version of Blender."""
    if hasattr(action, "fcurves"):
        return action.fcurves
    strips = [strip for layer in action.layers for strip in layer.strips]
    return [curve for strip in strips for bag in strip.channelbags for curve in bag.fcurves]


if __name__ == "__main__":
    convert(*sys.argv[sys.argv.index("--") + 1 :])
