"""FBX files that Blender writes from captures of the sample data, for the tests of the reader.

Run as a program in a Python with bpy, it writes the files of ``tests/files/fbx`` again:
``python tests/files/fbx_by_blender.py tests/files/fbx && gzip -9n tests/files/fbx/*.fbx``.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

FIRST, N_FRAMES = 25, 9
FILES = {
    # as Mixamo names joints, with leaf bones, a turned and moved armature, and z up in the file
    "mixamo": {"captures": ["ana/jump_1"], "prefix": "mixamorig:", "moved": True,
               "export": {"axis_forward": "Y", "axis_up": "Z"}},
    # two takes, helper bones, other bone axes, metres
    "two_takes": {"captures": ["ana/bow_1", "ana/jump_1"], "helpers": True,
                  "export": {"primary_bone_axis": "X", "secondary_bone_axis": "-Y",
                             "apply_scale_options": "FBX_SCALE_UNITS", "add_leaf_bones": False,
                             "bake_anim_simplify_factor": 0.001}},  # which drops still curves
    # keys at twice the rate of the scene, whose range is longer than they are
    "dense": {"captures": ["ana/jump_1"], "fps": 15, "range": (1, 20),
              "export": {"bake_anim_step": 0.5, "bake_anim_simplify_factor": 1.0,
                         "bake_anim_force_startend_keying": False,
                         "bake_anim_use_nla_strips": False, "bake_anim_use_all_actions": False}},
    "still": {"captures": ["ana/bow_1"], "still": True, "export": {}},
}  # fmt: skip
"""File -> how it is made."""


def cut(name: str, folder: Path) -> Path:
    """Write some frames of a sample capture as BVH."""
    text = Path(__file__, "../../../sample_data/captures", f"{name}.bvh").resolve().read_text()
    head, frames = text.split("Frame Time:")
    lines = frames.split("\n")
    head = head[: head.index("Frames:")] + f"Frames: {N_FRAMES}\n"
    path = folder / f"{name.split('/')[-1]}.bvh"
    chosen = [lines[0], *lines[1 + FIRST : 1 + FIRST + N_FRAMES]]
    path.write_text(f"{head}Frame Time:" + "\n".join(chosen) + "\n")
    return path


def write(folder: Path, only: str | None = None) -> None:
    """Write the files with the bpy of this Python, in a process of its own."""
    jobs = []
    for name, how in FILES.items():
        if only in (None, name):
            sources = [str(cut(capture, folder)) for capture in how["captures"]]
            jobs.append({**how, "sources": sources, "target": str(folder / f"{name}.fbx")})
    command = [sys.executable, __file__, "--child", json.dumps(jobs)]
    done = subprocess.run(command, capture_output=True, timeout=120)
    if done.returncode:
        raise RuntimeError(done.stderr.decode()[-2000:])
    for job in jobs:
        for source in job["sources"]:
            Path(source).unlink(missing_ok=True)


def _write_all(jobs: list[dict]) -> None:
    import bpy  # noqa: I001  it brings addon_utils
    import addon_utils

    for job in jobs:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable("io_anim_bvh")
        addon_utils.enable("io_scene_fbx")
        first = None
        for source in job["sources"]:
            bpy.ops.import_anim.bvh(
                filepath=source, global_scale=0.01, update_scene_fps=True, rotate_mode="QUATERNION"
            )
            if first is None:
                first = bpy.context.object
            else:
                bpy.data.objects.remove(bpy.context.object)  # its action stays
        bpy.context.view_layer.objects.active = first
        for bone in first.data.bones:
            bone.name = job.get("prefix", "") + bone.name
        if job.get("helpers"):
            _add_helpers(bpy, first)
        if job.get("moved"):
            first.location, first.rotation_euler = (1.0, 2.0, 0.0), (0.0, 0.0, 0.5)
        if job.get("still"):
            first.animation_data_clear()
        scene = bpy.context.scene
        scene.render.fps = job.get("fps", scene.render.fps)
        scene.frame_start, scene.frame_end = job.get("range", (scene.frame_start, scene.frame_end))
        bpy.ops.export_scene.fbx(
            filepath=job["target"],
            object_types={"ARMATURE"},
            **{"bake_anim_simplify_factor": 0.0, **job["export"]},
        )


def _add_helpers(bpy, armature) -> None:
    """Twist bones below arms, and a bone for a foot's target beside the pelvis."""
    bpy.ops.object.mode_set(mode="EDIT")
    bones = armature.data.edit_bones
    for name in ("LeftArm", "RightArm"):
        twist = bones.new(f"{name}_twist")
        twist.head, twist.tail, twist.parent = bones[name].head, bones[name].tail, bones[name]
    target = bones.new("foot_target")
    target.head, target.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 0.1)
    bpy.ops.object.mode_set(mode="OBJECT")


if __name__ == "__main__":
    if sys.argv[1] == "--child":
        _write_all(json.loads(sys.argv[2]))
    else:
        write(Path(sys.argv[1]))
