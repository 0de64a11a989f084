#!/usr/bin/env bash
# Guess: a BVH joint may have one rotation channel (a knee), and Blender imports it.
# What happens: the importer ends with a KeyError; three rotation channels are needed at each joint
# that has any.
# Who meets it: whoever writes hinges as what they are. Other readers take the same file.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check bpy==4.5.15 bvhio==1.5.4 2>/dev/null
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
sed -e 's/CHANNELS 3 Zrotation Xrotation Yrotation/CHANNELS 1 Xrotation/' \
    -e 's/^\(0 90 . 0 0 0\) 0 0 0/\1 30/' take.bvh >hinge.bvh
venv/bin/python - <<'PY'
import bpy
import addon_utils
import bvhio

names = [joint.Name for joint, _, _ in bvhio.readAsHierarchy("hinge.bvh").layout()]
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("io_anim_bvh")
said = {}
for name in ("take.bvh", "hinge.bvh"):
    try:
        bpy.ops.import_anim.bvh(filepath=name)
        said[name] = "read"
    except RuntimeError as error:
        said[name] = next(line for line in str(error).splitlines() if "KeyError" in line)
print("Blender", bpy.app.version_string, said, "| bvhio 1.5.4 reads", names)
assert said["take.bvh"] == "read"
assert said["hinge.bvh"].startswith("KeyError: (0, None, None)"), "the behaviour has changed"
assert names == ["Hips", "Spine"]
PY
