/**
 * Light from the sky, from a lamp and from behind, and the shadows on the ground.
 *
 * The lamp has a shadow map. Where there is no graphics processor it costs more than the bodies;
 * what moves then has soft spots instead, one for each point of a body, wider and paler the higher
 * it is.
 */

import * as THREE from "three";
import type { StageColours } from "./colours.ts";
import { BRIGHT, TO_BACK, TO_LAMP } from "./lamps.ts";

/** A ball that takes light from the ground: its middle and its radius, metres. */
export type Ball = readonly [x: number, y: number, z: number, radius: number];

/** Points of the shadow map across; and how far from a lamp its eye is, metres. */
const MAP = 512;
const AWAY = 30;
/** What takes shadows grows in steps of this, so that their edges do not crawl, metres. */
const STEP = 1;

const SPOT_VERTEX = /* glsl */ `
  attribute vec4 spot;
  varying vec2 vPlace;
  varying float vDark;
  void main() {
    vPlace = position.xz;
    vDark = spot.w;
    vec3 place = vec3(spot.x + spot.z * position.x, 0.0, spot.y + spot.z * position.z);
    gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
  }
`;
const SPOT_FRAGMENT = /* glsl */ `
  varying vec2 vPlace;
  varying float vDark;
  uniform vec3 colour;
  void main() {
    float near = max(1.0 - dot(vPlace, vPlace), 0.0);
    gl_FragColor = vec4(colour, vDark * near * near);
  }
`;
/** The most spots; how much wider they are for each metre of height; and how dark. By eye. */
const SPOTS = 512;
const WIDER = 0.32;
const DARK = 1;

// All screens share these: a program that no material uses is forgotten.
const SPOT_PAINT = new THREE.ShaderMaterial({
  vertexShader: SPOT_VERTEX,
  fragmentShader: SPOT_FRAGMENT,
  uniforms: { colour: { value: new THREE.Color() } },
  transparent: true,
  depthWrite: false,
});
const FLOOR_PAINT = new THREE.ShadowMaterial({ depthWrite: false });
const SQUARE = new THREE.PlaneGeometry(2, 2).rotateX(-Math.PI / 2);

/** Spots on the ground. */
function makeSpots(): { object: THREE.Mesh; show(balls: readonly Ball[]): void; dispose(): void } {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("position", SQUARE.getAttribute("position"));
  geometry.setIndex(SQUARE.getIndex());
  const spots = new THREE.InstancedBufferAttribute(new Float32Array(4 * SPOTS), 4);
  geometry.setAttribute("spot", spots);
  const object = new THREE.Mesh(geometry, SPOT_PAINT);
  object.frustumCulled = false;
  object.renderOrder = -2; // below the lines of the ground
  return {
    object,
    show(balls) {
      geometry.instanceCount = Math.min(balls.length, SPOTS);
      for (let i = 0; i < geometry.instanceCount; i += 1) {
        const [x, y, z, radius] = balls[i]!;
        const high = Math.max(y - radius, 0);
        const wide = 1.6 * radius + WIDER * high;
        const dark = DARK * Math.min((radius / wide) ** 2 * 4, 1);
        const aside = Math.max(y, 0) / TO_LAMP[1];
        spots.setXYZW(i, x - aside * TO_LAMP[0], z - aside * TO_LAMP[2], wide, dark);
      }
      spots.needsUpdate = true;
    },
    dispose: () => geometry.dispose(),
  };
}

/** Make the light of a scene. */
export function makeLight() {
  const object = new THREE.Group();
  const fine = new THREE.Group();
  const sky = new THREE.HemisphereLight(0xffffff, 0xffffff, Math.PI * BRIGHT.sky);
  sky.groundColor.setScalar(BRIGHT.ground / BRIGHT.sky);
  const lamp = new THREE.DirectionalLight(0xffffff, Math.PI * BRIGHT.lamp);
  const back = new THREE.DirectionalLight(0xffffff, Math.PI * BRIGHT.back);
  back.position.set(...TO_BACK);
  lamp.castShadow = true;
  lamp.shadow.mapSize.set(MAP, MAP);
  lamp.shadow.radius = 2.5;
  lamp.shadow.normalBias = 0.02;
  const { camera } = lamp.shadow;
  const floor = new THREE.Mesh(SQUARE, FLOOR_PAINT);
  floor.receiveShadow = true;
  floor.renderOrder = -2; // below the lines of the ground
  const spots = makeSpots();
  fine.add(sky, lamp, lamp.target, back, floor);
  object.add(fine, spots.object);
  return {
    /** To be added to a scene. */
    object,
    /** Let shadows fall of all these balls, which the bodies consist of. */
    around(balls: readonly Ball[]): void {
      if (spots.object.visible) return spots.show(balls);
      const [low, high] = [
        [Infinity, 0, Infinity],
        [-Infinity, 1, -Infinity],
      ];
      for (const ball of balls) {
        for (let n = 0; n < 3; n += 1) {
          low[n] = Math.min(low[n]!, ball[n]! - ball[3]);
          high[n] = Math.max(high[n]!, ball[n]! + ball[3]);
        }
      }
      if (balls.length === 0) return;
      const tall = high[1]!;
      // The shadow falls beside what casts it.
      const [x, z] = [(low[0]! + high[0]!) / 2, (low[2]! + high[2]!) / 2];
      const wide = Math.hypot(high[0]! - low[0]!, high[2]! - low[2]!) + 0.6 * tall;
      const size = Math.ceil(wide / STEP + 0.2) * STEP;
      const point = size / MAP;
      lamp.target.position.set(Math.round(x / point) * point, tall / 2, Math.round(z / point) * point);
      lamp.position.copy(lamp.target.position).addScaledVector(new THREE.Vector3(...TO_LAMP), AWAY);
      camera.left = camera.bottom = -size / 2;
      camera.right = camera.top = size / 2;
      camera.near = AWAY - size - tall;
      camera.far = AWAY + size + tall;
      camera.updateProjectionMatrix();
      floor.position.set(x - 0.25 * tall, 0, z - 0.22 * tall);
      floor.scale.set(size / 2, 1, size / 2);
    },
    /** With a shadow map, or with spots. */
    setFine(is: boolean): void {
      fine.visible = is;
      spots.object.visible = !is;
    },
    setColours(colours: StageColours): void {
      SPOT_PAINT.uniforms["colour"]!.value = colours.shadow;
      FLOOR_PAINT.color = colours.shadow;
      FLOOR_PAINT.opacity = 1;
    },
    dispose(): void {
      spots.dispose();
      lamp.dispose();
    },
  };
}

export type Light = ReturnType<typeof makeLight>;
