/**
 * Many tapered capsules in one draw call.
 *
 * An instance has two ends with their radii and a colour. The vertex shader places one half of a
 * unit sphere at each end, so that caps stay round whatever the radii are.
 */

import * as THREE from "three";
import { CAPSULE } from "./body.ts";
import type { Drawn } from "./figures.ts";
import { TO_LAMP } from "./lamps.ts";

/** How finely a capsule is drawn: corners around it, and rings of each cap. */
export interface Fineness {
  around: number;
  rings: number;
}

export const BODY_FINENESS: Fineness = { around: 16, rings: 5 };
export const MARK_FINENESS: Fineness = { around: 8, rings: 2 };

/** The shape of one capsule, without its instances. */
function geometryOf(fineness: Fineness): THREE.InstancedBufferGeometry {
  const { position, half, index } = halfSpheres(fineness);
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("half_", new THREE.BufferAttribute(half, 1));
  geometry.setIndex(index);
  geometry.instanceCount = 0;
  return geometry;
}

/** Directions on the unit sphere, cut in two halves along z; `half` says which end a vertex belongs to. */
function halfSpheres({ around, rings }: Fineness): {
  position: Float32Array;
  half: Float32Array;
  index: number[];
} {
  const rows: [number, number][] = [];
  for (let ring = 0; ring <= rings; ring += 1) rows.push([-1 + ring / rings, 0]);
  for (let ring = 0; ring <= rings; ring += 1) rows.push([ring / rings, 1]);
  const position: number[] = [];
  const half: number[] = [];
  const index: number[] = [];
  for (const [height, side] of rows) {
    const angle = (height * Math.PI) / 2;
    for (let step = 0; step <= around; step += 1) {
      const turn = (step / around) * 2 * Math.PI;
      position.push(Math.cos(angle) * Math.cos(turn), Math.cos(angle) * Math.sin(turn), Math.sin(angle));
      half.push(side);
    }
  }
  const wide = around + 1;
  for (let row = 0; row + 1 < rows.length; row += 1) {
    for (let step = 0; step < around; step += 1) {
      const a = row * wide + step;
      index.push(a, a + 1, a + wide, a + 1, a + wide + 1, a + wide);
    }
  }
  return { position: new Float32Array(position), half: new Float32Array(half), index };
}

const PLACE = /* glsl */ `
  attribute float half_;
  attribute vec4 endA;
  attribute vec4 endB;
  attribute vec3 tint;
  mat3 frameAlong(vec3 axis) {
    vec3 helper = abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 side = normalize(cross(helper, axis));
    return mat3(side, cross(axis, side), axis);
  }
  vec3 direction() {
    vec3 along = endB.xyz - endA.xyz;
    float reach = length(along);
    return frameAlong(reach > 1e-5 ? along / reach : vec3(0.0, 1.0, 0.0)) * position;
  }
  vec3 place(vec3 towards) {
    vec4 end = half_ < 0.5 ? endA : endB;
    return end.xyz + end.w * towards;
  }
`;

const BODY_VERTEX = /* glsl */ `${PLACE}
  varying vec3 vNormal;
  varying vec3 vTint;
  varying vec3 vToEye;
  varying float vHeight;
  void main() {
    vNormal = direction();
    vTint = tint;
    vec3 world = place(vNormal);
    vHeight = world.y;
    vToEye = cameraPosition - world;
    gl_Position = projectionMatrix * viewMatrix * vec4(world, 1.0);
  }
`;

// Light from the sky and from the ground, a lamp from one side, and a rim that lifts the outline
// off the ground. The numbers were chosen by eye.
const BODY_FRAGMENT = /* glsl */ `
  varying vec3 vNormal;
  varying vec3 vTint;
  varying vec3 vToEye;
  varying float vHeight;
  uniform vec3 toLight;
  void main() {
    vec3 normal = normalize(vNormal);
    float sky = 0.5 + 0.5 * normal.y;
    float lamp = max(dot(normal, toLight), 0.0);
    float rim = pow(1.0 - max(dot(normal, normalize(vToEye)), 0.0), 3.0);
    float near = mix(0.86, 1.0, smoothstep(0.0, 0.35, vHeight));
    float light = (0.58 + 0.30 * sky + 0.36 * lamp) * near;
    gl_FragColor = vec4(vTint * light + vec3(0.10) * rim, 1.0);
  }
`;

const DEPTH_VERTEX = /* glsl */ `${PLACE}
  void main() {
    gl_Position = projectionMatrix * viewMatrix * vec4(place(direction()), 1.0);
  }
`;

const PRINT_VERTEX = /* glsl */ `${PLACE}
  varying vec3 vTint;
  void main() {
    vTint = tint;
    vec3 world = place(direction());
    world.y = 0.0;
    gl_Position = projectionMatrix * viewMatrix * vec4(world, 1.0);
  }
`;

const PRINT_FRAGMENT = /* glsl */ `
  varying vec3 vTint;
  void main() { gl_FragColor = vec4(vTint, 1.0); }
`;

// All screens share the materials: a program that no material uses is forgotten, and a browser
// takes long to compile it again.
const BODY = new THREE.ShaderMaterial({
  vertexShader: BODY_VERTEX,
  fragmentShader: BODY_FRAGMENT,
  uniforms: { toLight: { value: new THREE.Vector3(...TO_LAMP) } },
});
/** What the shadow map sees. */
const DEPTH = new THREE.ShaderMaterial({
  vertexShader: DEPTH_VERTEX,
  fragmentShader: "void main() {}",
});
const PRINT = new THREE.ShaderMaterial({
  vertexShader: PRINT_VERTEX,
  fragmentShader: PRINT_FRAGMENT,
  depthWrite: false,
  side: THREE.DoubleSide,
});

/** How capsules are drawn: as bodies with their shadows, as bodies alone, or flat on the ground. */
export type Look = "shaded" | "plain" | "print";

/** Make room for a number of capsules. */
export function makeCapsules(room: number, fineness: Fineness, look: Look) {
  const ends = new THREE.InstancedInterleavedBuffer(new Float32Array(room * CAPSULE), CAPSULE);
  ends.setUsage(THREE.DynamicDrawUsage);
  const tint = new THREE.InstancedBufferAttribute(new Float32Array(room * 3), 3);
  const geometry = geometryOf(fineness);
  geometry.setAttribute("endA", new THREE.InterleavedBufferAttribute(ends, 4, 0));
  geometry.setAttribute("endB", new THREE.InterleavedBufferAttribute(ends, 4, 4));
  geometry.setAttribute("tint", tint);
  const object = new THREE.Mesh(geometry, look === "print" ? PRINT : BODY);
  object.frustumCulled = false;
  object.castShadow = look === "shaded";
  object.customDepthMaterial = DEPTH;
  if (look === "print") object.renderOrder = -1; // as the lines of the ground, below bodies
  return {
    /** To be added to a scene. */
    object,
    /** Show these capsules. */
    show({ capsules, tints, count }: Drawn): void {
      object.visible = count > 0;
      (ends.array as Float32Array).set(capsules.subarray(0, count * CAPSULE));
      ends.needsUpdate = true;
      (tint.array as Float32Array).set(tints.subarray(0, count * 3));
      tint.needsUpdate = true;
      geometry.instanceCount = count;
    },
    dispose: () => geometry.dispose(),
  };
}

export type Capsules = ReturnType<typeof makeCapsules>;
