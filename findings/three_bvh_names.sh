#!/usr/bin/env bash
# Guess: the clip that three's BVHLoader returns moves the skeleton that comes with it, whatever the
# joints are called.
# What happens: joints with a colon in their names ("rig:Spine") do not move: their tracks find no
# node. A name with a space is cut at the space, so that all joints of one prefix get one name.
# Who meets it: files of character tools put "mixamorig:" or "Bip01 " before every name.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
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
cat >names.mjs <<'JS'
import { readFileSync } from "node:fs";
import { AnimationMixer, REVISION } from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
console.warn = console.error = () => {};
const text = readFileSync("take.bvh", "utf8").replace("0 90 5 0 0 0 0 0 0", "0 90 5 0 0 0 0 80 0");
const found = {};
for (const name of ["Spine", "rig:Spine", "Spine.x", "Bip01 Spine"]) {
  const { clip, skeleton } = new BVHLoader().parse(text.replace("JOINT Spine", `JOINT ${name}`));
  const mixer = new AnimationMixer(skeleton.bones[0]);
  mixer.clipAction(clip).play();
  mixer.setTime(clip.duration * 0.999);
  const joint = skeleton.bones[1];
  found[name] = `${joint.name} ${Math.abs(joint.quaternion.x) > 0.1 ? "moves" : "stays"}`;
}
console.log("three", REVISION, JSON.stringify(found));
const wanted = { Spine: "Spine moves", "rig:Spine": "rig:Spine stays", "Spine.x": "Spine.x moves",
  "Bip01 Spine": "Bip01 moves" };
if (JSON.stringify(found) !== JSON.stringify(wanted)) throw new Error("the behaviour has changed");
JS
node names.mjs
