/** The ground: a plane that fades into the background, with lines every metre. */

import * as THREE from "three";
import type { StageColours } from "./colours.ts";

const VERTEX = /* glsl */ `
  varying vec2 vPlace;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    vPlace = world.xz;
    gl_Position = projectionMatrix * viewMatrix * world;
  }
`;

const FRAGMENT = /* glsl */ `
  varying vec2 vPlace;
  uniform vec3 line;
  uniform vec3 strong;
  uniform vec2 centre;
  uniform float reach;
  float lines(vec2 place, float every) {
    vec2 near = abs(fract(place / every - 0.5) - 0.5) * every;
    vec2 width = fwidth(place);
    vec2 drawn = 1.0 - smoothstep(width * 0.4, width * 1.4, near);
    // Where lines are closer than the pixels, they become an even tone.
    vec2 dense = clamp(width / every, 0.0, 1.0);
    drawn = mix(drawn, vec2(0.1), smoothstep(0.2, 0.6, dense));
    return max(drawn.x, drawn.y);
  }
  void main() {
    float fade = 1.0 - smoothstep(reach * 0.25, reach, distance(vPlace, centre));
    float metre = lines(vPlace, 1.0);
    float five = lines(vPlace, 5.0);
    gl_FragColor = vec4(mix(line, strong, five), max(metre * 0.9, five) * fade);
  }
`;

export interface Ground {
  readonly object: THREE.Mesh;
  /** Keep the visible part around a place. */
  centre(x: number, z: number, reach: number): void;
  setColours(colours: StageColours): void;
  dispose(): void;
}

export function makeGround(): Ground {
  const geometry = new THREE.PlaneGeometry(2, 2);
  geometry.rotateX(-Math.PI / 2);
  const material = new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
    uniforms: {
      line: { value: new THREE.Color() },
      strong: { value: new THREE.Color() },
      centre: { value: new THREE.Vector2() },
      reach: { value: 14 },
    },
  });
  const object = new THREE.Mesh(geometry, material);
  object.renderOrder = -1;
  object.frustumCulled = false;
  return {
    object,
    centre(x, z, reach) {
      object.position.set(x, 0, z);
      object.scale.set(reach, 1, reach); // nothing is seen beyond: no pixels for it
      (material.uniforms["centre"]!.value as THREE.Vector2).set(x, z);
      material.uniforms["reach"]!.value = reach;
    },
    setColours(colours) {
      material.uniforms["line"]!.value = colours.line;
      material.uniforms["strong"]!.value = colours.lineStrong;
    },
    dispose() {
      geometry.dispose();
      material.dispose();
    },
  };
}
