#!/usr/bin/env bash
# Guess: a BVH joint with an OFFSET and position channels is placed alike by all
# readers, since both come from the same two lines of the file.
# Instead: Blender, bvhio and bvhsdk put the channels in the OFFSET's place (hips
# at 90), three.js adds them to it (hips at 180), and pybvh refuses positions
# below the root.
# A user meets a body that floats at twice its height on a web page, and stands
# on the floor in Blender. A root OFFSET of 0 0 0 is placed alike everywhere.
# Needs Python 3.11 and Node.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check bpy==4.5.15 numpy==1.26.4
python3 -m venv readers
readers/bin/pip install --quiet --quiet --disable-pip-version-check bvhio==1.5.4 bvhsdk==0.2.1 pybvh==0.9.0
npm init --yes >npm.log
npm install --silent --no-audit --no-fund three@0.187.0 >>npm.log
cat >body.bvh <<'END'
HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 20 0
    CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 10 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
0 90 0 0 0 0 0 20 0 0 0 0
0 90 5 0 0 0 0 25 0 0 0 0
END
cat >blender.py <<'END'
import bpy
import addon_utils  # comes with bpy
addon_utils.enable("io_anim_bvh")
bpy.ops.import_anim.bvh(filepath="body.bvh", axis_forward="-Z", axis_up="Y")
bones = next(o for o in bpy.data.objects if o.type == "ARMATURE").pose.bones
bpy.context.scene.frame_set(2)
heights = [round(bones[n].head.z, 2) for n in ("Hips", "Spine")]
print("SEEN Blender", bpy.app.version_string.split()[0], heights)
assert heights == [90, 115], heights
END
cat >three.mjs <<'END'
import fs from "node:fs";
import * as THREE from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
const { clip, skeleton } = new BVHLoader().parse(fs.readFileSync("body.bvh", "utf8"));
const root = skeleton.bones[0];
const mixer = new THREE.AnimationMixer(root);
mixer.clipAction(clip).play();
mixer.setTime(clip.duration - 1e-6);
root.updateMatrixWorld(true);
const heights = skeleton.bones.slice(0, 2).map(b => Math.round(b.getWorldPosition(new THREE.Vector3()).y * 100) / 100);
console.log("three", THREE.REVISION, heights);
if (heights.join() !== "180,225") throw new Error("changed: " + heights);
END
cat >readers.py <<'END'
from importlib.metadata import version

import bvhio
import bvhsdk
import pybvh

body = bvhio.readAsHierarchy("body.bvh")
body.loadPose(1)
heights = [round(joint.PositionWorld.y, 2) for joint, _, _ in body.layout()]
print("bvhio", version("bvhio"), heights)
assert heights == [90, 115], heights
body = bvhsdk.ReadFile("body.bvh")
heights = [round(float(joint.getPosition(1)[1]), 2) for joint in body.getlistofjoints()]
print("bvhsdk", version("bvhsdk"), heights)
assert heights == [90, 115], heights
try:
    pybvh.read_bvh_file("body.bvh")
except ValueError:
    print("pybvh", version("pybvh"), "refuses position channels below the root")
else:
    raise SystemExit("changed: pybvh reads positions below the root")
END
venv/bin/python blender.py | grep SEEN
node three.mjs
readers/bin/python readers.py
