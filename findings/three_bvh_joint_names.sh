#!/usr/bin/env bash
# Guess: a clip that a loader returns together with its skeleton moves that
# skeleton, whatever its joints are called.
# Instead: three.js's BVHLoader keeps a colon in a name and makes tracks of it, but
# a track's name is read by other rules when it is played: the tracks of
# "rig:Spine" find no bone, and the joint stands still, with a warning in the
# console. A dot does no harm. A name with a space is cut at the space.
# A user meets a body that glides along without bending: MotionBuilder and Mixamo
# put "mixamorig:" before every joint.
# Needs Node.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init --yes >npm.log
npm install --silent --no-audit --no-fund three@0.187.0 >>npm.log
cat >names.mjs <<'END'
import * as THREE from "three";
import { BVHLoader } from "three/addons/loaders/BVHLoader.js";
const file = name => `HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT ${name}
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
0 90 0 0 0 0 90 0 0
`;
console.warn = () => {};
const degrees = name => {
  const { clip, skeleton } = new BVHLoader().parse(file(name));
  const mixer = new THREE.AnimationMixer(skeleton.bones[0]);
  mixer.clipAction(clip).play();
  mixer.setTime(clip.duration - 1e-6);
  return [skeleton.bones[1].name, Math.round(2 * Math.acos(skeleton.bones[1].quaternion.w) * 180 / Math.PI)];
};
console.log("three", THREE.REVISION, "(the file turns the joint by 90 degrees)");
const expected = { "Spine": "Spine,90", "rig:Spine": "rig:Spine,0", "Spine.001": "Spine.001,90", "Mid Spine": "Mid,90" };
for (const [name, answer] of Object.entries(expected)) {
  const seen = degrees(name);
  console.log(JSON.stringify(name), "is called", JSON.stringify(seen[0]), "and turns by", seen[1]);
  if (seen.join() !== answer) throw new Error("changed: " + seen);
}
END
node names.mjs
