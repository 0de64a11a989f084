#!/usr/bin/env bash
# Guess: SkeletonUtils.retargetClip takes the rest poses of both skeletons into
# account: a source that stays in its rest pose leaves the target in its own.
# Instead: each bone of the target gets the world orientation of the source's bone.
# Where the rest orientations differ (bones along Y in one rig, along X in the
# other; an A pose and a T pose), the body is bent from the first frame on: a leg that
# hangs down in both rests points sideways. localOffsets, a matrix a bone that the
# caller has to work out, is the only cure. Hips keep the source's height in the
# target's units unless scale is given.
# A user meets it with every pair of rigs of two programs.
# Needs Node.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init --yes >npm.log
npm install --silent --no-audit --no-fund three@0.187.0 >>npm.log
cat >retarget.mjs <<'END'
import * as THREE from "three";
import { retargetClip } from "three/addons/utils/SkeletonUtils.js";
// A leg of 40 and 40 that hangs down from the hip at the given height; the bones of the second rig lie along X.
function leg(length, alongX) {
  const [hip, knee, ankle] = ["hip", "knee", "ankle"].map(name => Object.assign(new THREE.Bone(), { name }));
  hip.add(knee); knee.add(ankle);
  hip.position.y = 2 * length;
  if (alongX) hip.rotation.z = -Math.PI / 2;
  for (const bone of [knee, ankle]) bone.position.set(alongX ? length : 0, alongX ? 0 : -length, 0);
  const mesh = new THREE.SkinnedMesh(new THREE.BufferGeometry());
  mesh.add(hip);
  mesh.updateMatrixWorld(true);
  mesh.bind(new THREE.Skeleton([hip, knee, ankle]));
  return mesh;
}
const place = mesh => mesh.skeleton.bones.map(b => b.getWorldPosition(new THREE.Vector3()).toArray().map(x => Math.round(x) + 0).join(" ")).join(", ");
console.log("three", THREE.REVISION, "(hip, knee and ankle)");
for (const [alongX, expected] of [[false, "0 80 0, 0 60 0, 0 40 0"], [true, "0 80 0, 20 80 0, 40 80 0"]]) {
  const source = leg(40, false), target = leg(20, alongX);
  console.log("bones along", alongX ? "X" : "Y");
  console.log("  source at rest:  ", place(source));
  console.log("  target at rest:  ", place(target));
  const still = new THREE.AnimationClip("still", -1, [
    new THREE.VectorKeyframeTrack(".bones[hip].position", [0, 1], [0, 80, 0, 0, 80, 0]),
    new THREE.QuaternionKeyframeTrack(".bones[hip].quaternion", [0, 1], [0, 0, 0, 1, 0, 0, 0, 1]),
  ]);
  const clip = retargetClip(target, source, still, { hip: "hip", getBoneName: bone => bone.name });
  const mixer = new THREE.AnimationMixer(target);
  mixer.clipAction(clip).play();
  mixer.setTime(0.5);
  target.updateMatrixWorld(true);
  const seen = place(target);
  console.log("  target retargeted:", seen);
  if (seen !== expected) throw new Error("changed");
}
END
node retarget.mjs
