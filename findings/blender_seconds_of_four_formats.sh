#!/usr/bin/env bash
# Guess: one second of motion at 60 frames a second, imported into a new scene of
# 24 with an importer's defaults, lasts one second, from each format alike.
# Instead, with 61 keys each: BVH takes its frames as frames of the scene, 2.5 s
# (the frame time is not used); USD too, 2.5 s (timeCodesPerSecond is not used); FBX keeps 1 s and changes the
# scene's rate to 60; glTF keeps 1 s and the scene, with keys between frames.
# Frame 0 of the export is frame 1 in BVH and FBX, and 0 in glTF and USD.
# A user who imports one capture from two formats gets two speeds.
# Needs Python 3.11.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check bpy==4.5.15 numpy==1.26.4
cat >formats.py <<'END'
import bpy
import addon_utils  # comes with bpy


def new(rate):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for name in ("io_anim_bvh", "io_scene_fbx", "io_scene_gltf2"):
        addon_utils.enable(name)
    bpy.context.scene.render.fps = rate


new(60)
bpy.ops.object.armature_add()
bone = bpy.context.object.pose.bones[0]
for frame in range(61):
    bone.location.x = frame / 60
    bone.keyframe_insert("location", frame=frame)
bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, 60
bpy.ops.export_anim.bvh(filepath="move.bvh", frame_start=0, frame_end=60)
bpy.ops.export_scene.fbx(filepath="move.fbx", add_leaf_bones=False)
bpy.ops.export_scene.gltf(filepath="move.glb")
bpy.ops.wm.usd_export(filepath="move.usda", export_animation=True)
usda = open("move.usda").read()
assert "timeCodesPerSecond = 60" in usda, usda[:500]
print("SEEN Blender", bpy.app.version_string.split()[0])
for read, name, expected in (
    (lambda f: bpy.ops.import_anim.bvh(filepath=f), "move.bvh", (1, 61, 24, 2.5)),
    (lambda f: bpy.ops.import_scene.fbx(filepath=f), "move.fbx", (1, 61, 60, 1)),
    (lambda f: bpy.ops.import_scene.gltf(filepath=f), "move.glb", (0, 24, 24, 1)),
    (lambda f: bpy.ops.wm.usd_import(filepath=f), "move.usda", (0, 60, 24, 2.5)),
):
    new(24)
    read(name)
    (action,) = bpy.data.actions
    first, last = action.frame_range
    rate = bpy.context.scene.render.fps / bpy.context.scene.render.fps_base
    seen = (round(first, 3), round(last, 3), round(rate, 3), round((last - first) / rate, 3))
    print("SEEN", name, "first and last frame, rate of the scene, seconds:", seen)
    assert seen == expected, seen
END
venv/bin/python formats.py >log 2>&1 || { tail -5 log; exit 1; }
grep SEEN log
