#!/usr/bin/env bash
# Guess: a root with an OFFSET and position channels stands at the same place in every program.
# What happens: three's BVHLoader adds the channels to the OFFSET; Blender and bvhio let the
# channels take its place. Hips at 90 stand at 180 in three.
# Who meets it: whoever writes the standing height into the OFFSET, as many exporters do, and shows
# the file on a web page. An OFFSET of 0 0 0 is read alike by all.
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
echo '{"type": "module"}' >package.json
npm install --silent three@0.187.0 >/dev/null
cat >place.mjs <<'JS'
import { readFileSync } from "node:fs";
import { AnimationMixer, REVISION } from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
const { clip, skeleton } = new BVHLoader().parse(readFileSync("take.bvh", "utf8"));
const mixer = new AnimationMixer(skeleton.bones[0]);
mixer.clipAction(clip).play();
mixer.setTime(0);
console.log(REVISION, skeleton.bones[0].position.y);
JS
venv/bin/python - <<'PY'
import subprocess

import bpy
import addon_utils
import bvhio

revision, three = subprocess.check_output(["node", "place.mjs"], text=True).split()
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("io_anim_bvh")
bpy.ops.import_anim.bvh(filepath="take.bvh", axis_forward="-Z", axis_up="Y")
bpy.context.scene.frame_set(1)
blender = round(bpy.context.object.pose.bones[0].head[2], 3)
root = bvhio.readAsHierarchy("take.bvh")
root.loadPose(0)
other = round(root.PositionWorld[1], 3)
print(f"height of the hips: three r{revision} {three}, Blender {bpy.app.version_string} {blender},"
      f" bvhio 1.5.4 {other}")
assert (float(three), blender, other) == (180.0, 90.0, 90.0), "the behaviour has changed"
PY
