#!/usr/bin/env bash
# Guess: Blender's BVH importer puts the first row at the frame it is asked for
# (frame_start), also at 0 or before.
# Instead: 0 and negative frames become 1 without a word.
# A user who wants frame n of the file at frame n of the scene (as in C3D, in
# glTF or in an array) is off by one against the other captures.
# Needs Python 3.11.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check bpy==4.5.15 numpy==1.26.4
cat >body.bvh <<'END'
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
END
cat >frames.py <<'END'
import bpy
import addon_utils  # comes with bpy

print("SEEN Blender", bpy.app.version_string.split()[0])
for asked, expected in ((10, 10), (1, 1), (0, 1), (-5, 1)):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("io_anim_bvh")
    bpy.ops.import_anim.bvh(filepath="body.bvh", frame_start=asked)
    (action,) = bpy.data.actions
    first = action.frame_range[0]
    print("SEEN asked for", asked, "first key at", first)
    assert first == expected, first
END
venv/bin/python frames.py >log 2>&1 || { tail -5 log; exit 1; }
grep SEEN log
