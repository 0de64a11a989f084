#!/usr/bin/env bash
# Guess: a BVH joint may have one or two rotation channels (a knee, a wrist), as
# its CHANNELS line counts them; every reader turns the joint about these axes.
# Instead: Blender's importer stops with a KeyError and imports nothing, pybvh
# and bvhsdk refuse, three.js and bvhio read it.
# A user meets a file that plays on a web page and is an empty scene in Blender.
# Write three rotation channels for every joint.
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
cat >knee.bvh <<'END'
HIERARCHY
ROOT Hip
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Knee
  {
    OFFSET 0 -40 0
    CHANNELS 1 Xrotation
    JOINT Ankle
    {
      OFFSET 0 -40 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 0 10
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0 0
0 90 0 0 0 0 90 0 0 0
END
cat >blender.py <<'END'
import bpy
import addon_utils  # comes with bpy
addon_utils.enable("io_anim_bvh")
try:
    bpy.ops.import_anim.bvh(filepath="knee.bvh")
except RuntimeError as error:
    assert "KeyError" in str(error), error
    print("SEEN Blender", bpy.app.version_string.split()[0], "stops with a KeyError")
else:
    raise SystemExit("changed: Blender reads one rotation channel")
END
cat >three.mjs <<'END'
import fs from "node:fs";
import * as THREE from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
const { clip, skeleton } = new BVHLoader().parse(fs.readFileSync("knee.bvh", "utf8"));
const root = skeleton.bones[0];
const mixer = new THREE.AnimationMixer(root);
mixer.clipAction(clip).play();
mixer.setTime(clip.duration - 1e-6);
root.updateMatrixWorld(true);
const ankle = skeleton.bones[2].getWorldPosition(new THREE.Vector3()).toArray().map(Math.round).map(x => x + 0);
console.log("three", THREE.REVISION, "ankle at", ankle);
if (ankle.join() !== "0,50,-40") throw new Error("changed: " + ankle);
END
cat >readers.py <<'END'
from importlib.metadata import version

import bvhio
import bvhsdk
import pybvh

body = bvhio.readAsHierarchy("knee.bvh")
body.loadPose(1)
ankle = [round(x) for x in list(body.layout())[2][0].PositionWorld]
print("bvhio", version("bvhio"), "ankle at", ankle)
assert ankle == [0, 50, -40], ankle
for reader, error in ((pybvh.read_bvh_file, ValueError), (bvhsdk.ReadFile, NotImplementedError)):
    name = reader.__module__.split(".")[0]
    try:
        reader("knee.bvh")
    except error:
        print(name, version(name), "refuses with", error.__name__)
    else:
        raise SystemExit("changed: " + name)
END
venv/bin/python blender.py 2>&1 | grep -o "SEEN.*"
node three.mjs
readers/bin/python readers.py
