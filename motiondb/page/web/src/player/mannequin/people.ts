/**
 * Mannequins in a scene: one mesh for all, a skeleton for each, and a material for each colour.
 *
 * Where there is no graphics processor, what moves has a coarser mesh whose corners are placed here:
 * that costs a fraction of what a shader costs that an ordinary processor runs.
 */

import * as THREE from "three";
import type { Person } from "../figures.ts";
import { BRIGHT, TO_BACK, TO_LAMP } from "../lamps.ts";
import { BONES, makeRig, type Rig } from "./bones.ts";
import { meshOf, type Detail } from "./mesh.ts";
import { place } from "./skin.ts";

let shared: THREE.BufferGeometry | null = null;

function fineGeometry(): THREE.BufferGeometry {
  if (shared) return shared;
  const { position, normal, shade, bone, share, index } = meshOf("fine");
  shared = new THREE.BufferGeometry();
  shared.setAttribute("position", new THREE.BufferAttribute(position, 3));
  shared.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  const grey = Uint8Array.from({ length: 3 * shade.length }, (_, i) => shade[Math.floor(i / 3)]!);
  shared.setAttribute("color", new THREE.BufferAttribute(grey, 3, true));
  shared.setAttribute("skinIndex", new THREE.BufferAttribute(bone, 4));
  shared.setAttribute("skinWeight", new THREE.BufferAttribute(share, 4));
  shared.setIndex(new THREE.BufferAttribute(index, 1));
  return shared;
}

function roughGeometry(detail: Detail): THREE.BufferGeometry {
  const { position, shade, index } = meshOf(detail);
  const geometry = new THREE.BufferGeometry();
  for (const name of ["position", "normal"]) {
    const places = new THREE.BufferAttribute(new Float32Array(position.length), 3);
    geometry.setAttribute(name, places.setUsage(THREE.DynamicDrawUsage));
  }
  geometry.setAttribute("shade", new THREE.BufferAttribute(shade, 1, true));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

const glsl = (direction: readonly number[]): string =>
  `vec3(${direction.map((value) => value.toFixed(4)).join(", ")})`;

// The same light as that of the fine material, in every corner.
const ROUGH_VERTEX = /* glsl */ `
  attribute float shade;
  uniform vec3 colour;
  varying vec3 vLight;
  void main() {
    vec3 n = normalize(normal);
    float light = mix(${BRIGHT.ground}, ${BRIGHT.sky}, 0.5 + 0.5 * n.y);
    light += ${BRIGHT.lamp} * max(dot(n, ${glsl(TO_LAMP)}), 0.0);
    light += ${BRIGHT.back} * max(dot(n, ${glsl(TO_BACK)}), 0.0);
    vLight = colour * shade * light;
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
  }
`;
const ROUGH_FRAGMENT = /* glsl */ `
  varying vec3 vLight;
  void main() { gl_FragColor = vec4(vLight, 1.0); }
`;

interface Paint {
  fine: THREE.Material;
  rough: THREE.Material;
}

// Paints are kept: a program that no material uses is forgotten, and a browser takes long to
// compile it again.
const paints = new Map<string, Paint>();

function paintOf(colour: readonly [number, number, number]): Paint {
  const key = colour.join(" ");
  const known = paints.get(key);
  if (known) return known;
  const value = new THREE.Color(...colour);
  const fine = new THREE.MeshStandardMaterial({ color: value, vertexColors: true, roughness: 0.6 });
  const rough = new THREE.ShaderMaterial({
    vertexShader: ROUGH_VERTEX,
    fragmentShader: ROUGH_FRAGMENT,
    uniforms: { colour: { value } },
  });
  paints.set(key, { fine, rough });
  return { fine, rough };
}

/** Make some people. */
export function makePeople(people: readonly Person[]) {
  const object = new THREE.Group();
  const rigs = people.map(({ points }) => makeRig(points));
  const bones = BONES.map(() => new THREE.Matrix4());
  let fines: THREE.SkinnedMesh[] = [];
  let roughs: THREE.Mesh<THREE.BufferGeometry>[] = [];
  let rough: Detail = "fine"; // The detail of `roughs`, once there are any

  function makeFine(): THREE.SkinnedMesh {
    const mesh = new THREE.SkinnedMesh(fineGeometry());
    // The matrices of a rig lead from the rest pose: nothing is to be undone before.
    mesh.bind(
      new THREE.Skeleton(
        bones.map(() => new THREE.Bone()),
        bones,
      ),
      new THREE.Matrix4(),
    );
    return Object.assign(mesh, { castShadow: true, receiveShadow: true, frustumCulled: false });
  }

  /** Have meshes of a detail. */
  function prepare(detail: Detail): void {
    if (detail === "fine") {
      if (fines.length < rigs.length) object.add(...(fines = rigs.map(makeFine)));
    } else if (detail !== rough) {
      rough = detail;
      object.remove(...roughs);
      roughs.forEach(({ geometry }) => geometry.dispose());
      roughs = rigs.map(() => Object.assign(new THREE.Mesh(roughGeometry(detail)), { frustumCulled: false }));
      if (roughs.length > 0) object.add(...roughs);
    }
  }

  function moveFine({ skeleton }: THREE.SkinnedMesh, { matrices }: Rig): void {
    skeleton.bones.forEach((bone, i) => bone.matrixWorld.fromArray(matrices, 16 * i));
  }

  function moveRough({ geometry }: THREE.Mesh, { matrices }: Rig): void {
    const [places, normals] = [geometry.getAttribute("position"), geometry.getAttribute("normal")];
    place(meshOf(rough), matrices, places.array as Float32Array, normals.array as Float32Array);
    places.needsUpdate = true;
    normals.needsUpdate = true;
  }

  return {
    /** To be added to a scene. */
    object,
    /** Show these people, always in the same order; all but the fine mesh is moved by this processor. */
    show(now: readonly Person[], detail: Detail): void {
      const fine = detail === "fine";
      prepare(detail);
      now.forEach(({ pose, colour }, i) => {
        const paint = paintOf(colour);
        rigs[i]!.follow(pose);
        if (fines[i]) Object.assign(fines[i]!, { visible: fine, material: paint.fine });
        if (roughs[i]) Object.assign(roughs[i]!, { visible: !fine, material: paint.rough });
        if (fine) moveFine(fines[i]!, rigs[i]!);
        else moveRough(roughs[i]!, rigs[i]!);
      });
    },
    dispose(): void {
      for (const { skeleton } of fines) skeleton.dispose();
      for (const { geometry } of roughs) geometry.dispose();
    },
  };
}

export type People = ReturnType<typeof makePeople>;
