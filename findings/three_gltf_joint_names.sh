#!/usr/bin/env bash
# Guess: the name of a loaded glTF node is the name in the file.
# Instead: three.js's GLTFLoader takes colons, dots and brackets out, makes
# spaces "_", and numbers what has become equal. With nodes "a.b" and "ab", in
# this order, the object named "ab" is the first one, and the file's "ab" is
# called "ab_1". The file's own name is in userData.name.
# A user who looks joints up by the names of the capture finds none
# ("mixamorig:Hips"), or without a word another joint.
# Needs Node.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init --yes >npm.log
npm install --silent --no-audit --no-fund three@0.187.0 >>npm.log
cat >names.mjs <<'END'
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
globalThis.self = globalThis;
const names = ["mixamorig:Hips", "Left Hand", "a.b", "ab"];
const text = JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0, 1, 2, 3] }],
  nodes: names.map((name, i) => ({ name, translation: [i, 0, 0] })),
});
const { scene } = await new GLTFLoader().parseAsync(text, "");
console.log("three", THREE.REVISION);
for (const node of scene.children) console.log(JSON.stringify(node.userData.name ?? node.name), "is called", JSON.stringify(node.name));
const seen = scene.children.map(node => node.name).join();
if (seen !== "mixamorigHips,Left_Hand,ab,ab_1") throw new Error("changed: " + seen);
const found = scene.getObjectByName("ab").position.x;
console.log('getObjectByName("ab") answers node', found, "of the file, whose name is", JSON.stringify(names[found]));
if (found !== 2) throw new Error("changed");
END
node names.mjs
