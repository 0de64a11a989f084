#!/usr/bin/env bash
# Guess: Blender's BVH importer puts the first frame where `frame_start` says, also at 0.
# What happens: 0 is raised to 1 without a word, so that all keys come one frame later.
# Who meets it: a script that asks for frame 0 and exports frames 0 to N - 1 writes one frame of
# rest pose, and loses the last frame.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check bpy==4.5.15 2>/dev/null
cat >take.bvh <<"BVH"
HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 20 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 10 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0
0 90 5 0 0 0 0 0 0
BVH
venv/bin/python - <<'PY'
import bpy
import addon_utils

starts = {}
for asked in (0, 1, 10):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("io_anim_bvh")
    bpy.ops.import_anim.bvh(filepath="take.bvh", frame_start=asked)
    starts[asked] = int(bpy.context.object.animation_data.action.frame_range[0])
print("Blender", bpy.app.version_string, "frame_start asked -> first key:", starts)
assert starts == {0: 1, 1: 1, 10: 10}, "the behaviour has changed"
PY
