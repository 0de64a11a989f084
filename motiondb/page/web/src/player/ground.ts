/** The ground: lines every metre, or every five seen from far away, that fade into the background. */

import * as THREE from "three";
import type { StageColours } from "./colours.ts";

const VERTEX = /* glsl */ `
  attribute float across;
  uniform float unit;
  uniform float reach;
  uniform vec2 middle;
  uniform vec3 line;
  uniform vec3 strong;
  varying vec4 vColour;
  void main() {
    vec2 place = unit * (position.xz + floor(middle / unit + 0.5));
    float number = mix(place.x, place.y, across) / unit / 5.0;
    float fifth = step(abs(number - floor(number + 0.5)), 0.01);
    float fade = 1.0 - smoothstep(0.2, 1.0, distance(place, middle) / reach);
    vColour = vec4(mix(line, strong, fifth), fade);
    gl_Position = projectionMatrix * viewMatrix * vec4(place.x, 0.0, place.y, 1.0);
  }
`;

const FRAGMENT = /* glsl */ `
  varying vec4 vColour;
  void main() { gl_FragColor = vColour; }
`;

/** Lines on each side of the middle, and after how many of their distances each has a corner. */
const LINES = 12;
const PIECE = 4;

export interface Ground {
  readonly object: THREE.LineSegments;
  /** Keep the visible part around a place; `reach`: how far it is to be seen, metres. */
  centre(x: number, z: number, reach: number): void;
  setColours(colours: StageColours): void;
  dispose(): void;
}

export function makeGround(): Ground {
  const ends: number[] = [];
  const across: number[] = [];
  for (let line = -LINES; line <= LINES; line += 1) {
    for (let from = -LINES; from < LINES; from += PIECE) {
      ends.push(line, 0, from, line, 0, from + PIECE, from, 0, line, from + PIECE, 0, line);
      across.push(0, 0, 1, 1);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  geometry.setAttribute("across", new THREE.Float32BufferAttribute(across, 1));
  const uniforms = {
    line: { value: new THREE.Color() },
    strong: { value: new THREE.Color() },
    middle: { value: new THREE.Vector2() },
    reach: { value: LINES },
    unit: { value: 1 },
  };
  const material = new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
    uniforms,
  });
  const object = new THREE.LineSegments(geometry, material);
  object.renderOrder = -1;
  object.frustumCulled = false;
  return {
    object,
    centre(x, z, reach) {
      const unit = reach > 2 * LINES ? 5 : 1;
      uniforms.middle.value.set(x, z);
      uniforms.unit.value = unit;
      uniforms.reach.value = Math.min(reach, (LINES - 1) * unit);
    },
    setColours(colours) {
      uniforms.line.value = colours.line;
      uniforms.strong.value = colours.lineStrong;
    },
    dispose() {
      geometry.dispose();
      material.dispose();
    },
  };
}
