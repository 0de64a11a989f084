/**
 * Mannequins in a scene: one mesh for all, a skeleton for each, and a material for each colour.
 *
 * Where there is no graphics processor, what moves has a coarser mesh whose corners are placed here:
 * that costs a fraction of what a shader costs that an ordinary processor runs.
 */

import * as THREE from "three";
import type { Person } from "../figures.ts";
import { BRIGHT, TO_BACK, TO_LAMP } from "../light.ts";
import { makeRig } from "./bones.ts";
import { makeMesh, type Mesh } from "./mesh.ts";

export interface People {
  /** To be added to a scene. */
  readonly object: THREE.Group;
  /** Show these people, always in the same order, with the fine mesh or with the coarse one. */
  show(people: readonly Person[], fine: boolean): void;
  dispose(): void;
}

/** How much larger the steps of the fine and of the coarse mesh are than the finest. By eye. */
const COARSE = { fine: 1, rough: 1.75 };

const meshes = new Map<number, Mesh>();

/** A mesh is computed when it is first needed. */
function meshOf(coarse: number): Mesh {
  const mesh = meshes.get(coarse) ?? makeMesh(coarse);
  meshes.set(coarse, mesh);
  return mesh;
}

let shared: THREE.BufferGeometry | null = null;

function fineGeometry(): THREE.BufferGeometry {
  if (shared) return shared;
  const { position, normal, shade, bone, share, index } = meshOf(COARSE.fine);
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

function roughGeometry(): THREE.BufferGeometry {
  const { position, shade, index } = meshOf(COARSE.rough);
  const geometry = new THREE.BufferGeometry();
  for (const name of ["position", "normal"]) {
    const places = new THREE.BufferAttribute(new Float32Array(position.length), 3);
    geometry.setAttribute(name, places.setUsage(THREE.DynamicDrawUsage));
  }
  geometry.setAttribute("shade", new THREE.BufferAttribute(shade, 1, true));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

const glsl = ({ x, y, z }: THREE.Vector3): string =>
  `vec3(${[x, y, z].map((value) => value.toFixed(4)).join(", ")})`;

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

/** Place the corners of the coarse mesh as a skeleton moves them. */
function skin(geometry: THREE.BufferGeometry, skeleton: THREE.Skeleton): void {
  const { position, normal, bone, share } = meshOf(COARSE.rough);
  skeleton.update();
  const m = skeleton.boneMatrices!;
  const [places, normals] = [geometry.getAttribute("position"), geometry.getAttribute("normal")];
  for (let i = 0; i < position.length; i += 3) {
    const [x, y, z] = [position[i]!, position[i + 1]!, position[i + 2]!];
    const [nx, ny, nz] = [normal[i]!, normal[i + 1]!, normal[i + 2]!];
    let [px, py, pz, qx, qy, qz] = [0, 0, 0, 0, 0, 0];
    for (let n = (4 * i) / 3; share[n]! > 0 && n < (4 * i) / 3 + 4; n += 1) {
      const [s, b] = [share[n]!, 16 * bone[n]!];
      px += s * (m[b]! * x + m[b + 4]! * y + m[b + 8]! * z + m[b + 12]!);
      py += s * (m[b + 1]! * x + m[b + 5]! * y + m[b + 9]! * z + m[b + 13]!);
      pz += s * (m[b + 2]! * x + m[b + 6]! * y + m[b + 10]! * z + m[b + 14]!);
      qx += s * (m[b]! * nx + m[b + 4]! * ny + m[b + 8]! * nz);
      qy += s * (m[b + 1]! * nx + m[b + 5]! * ny + m[b + 9]! * nz);
      qz += s * (m[b + 2]! * nx + m[b + 6]! * ny + m[b + 10]! * nz);
    }
    places.setXYZ(i / 3, px, py, pz);
    normals.setXYZ(i / 3, qx, qy, qz);
  }
  places.needsUpdate = true;
  normals.needsUpdate = true;
}

/** Make some people. */
export function makePeople(people: readonly Person[]): People {
  const object = new THREE.Group();
  const rigs = people.map(({ points }) => makeRig(points));
  let [fines, roughs]: [THREE.SkinnedMesh[], THREE.Mesh<THREE.BufferGeometry>[]] = [[], []];

  function makeFine({ skeleton }: (typeof rigs)[number]): THREE.SkinnedMesh {
    const mesh = new THREE.SkinnedMesh(fineGeometry());
    mesh.bind(skeleton, new THREE.Matrix4());
    return Object.assign(mesh, { castShadow: true, receiveShadow: true, frustumCulled: false });
  }

  function makeRough(): THREE.Mesh<THREE.BufferGeometry> {
    return Object.assign(new THREE.Mesh(roughGeometry()), { frustumCulled: false });
  }

  return {
    object,
    show(now, fine) {
      if (fine && fines.length < rigs.length) object.add(...(fines = rigs.map(makeFine)));
      if (!fine && roughs.length < rigs.length) object.add(...(roughs = rigs.map(makeRough)));
      now.forEach(({ pose, colour }, i) => {
        const paint = paintOf(colour);
        rigs[i]!.follow(pose);
        if (fines[i]) Object.assign(fines[i]!, { visible: fine, material: paint.fine });
        if (roughs[i]) Object.assign(roughs[i]!, { visible: !fine, material: paint.rough });
        if (!fine) skin(roughs[i]!.geometry, rigs[i]!.skeleton);
      });
    },
    dispose() {
      for (const { skeleton } of rigs) skeleton.dispose();
      for (const { geometry } of roughs) geometry.dispose();
    },
  };
}
