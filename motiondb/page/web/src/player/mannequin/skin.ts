/** The corners of a mesh, moved by bones: where no graphics processor does it. */

import type { Mesh } from "./mesh.ts";

/** Write the places and the normals of the corners; normals are not scaled to length 1. */
export function place(mesh: Mesh, matrices: Float32Array, places: Float32Array, normals: Float32Array): void {
  const { position, normal, bone, share } = mesh;
  const m = matrices;
  for (let i = 0; i < position.length; i += 3) {
    const x = position[i]!;
    const y = position[i + 1]!;
    const z = position[i + 2]!;
    const nx = normal[i]!;
    const ny = normal[i + 1]!;
    const nz = normal[i + 2]!;
    let [px, py, pz, qx, qy, qz] = [0, 0, 0, 0, 0, 0];
    const first = (4 * i) / 3;
    for (let n = first; n < first + 4; n += 1) {
      const s = share[n]!;
      if (s === 0) break; // the shares are sorted
      const b = 16 * bone[n]!;
      px += s * (m[b]! * x + m[b + 4]! * y + m[b + 8]! * z + m[b + 12]!);
      py += s * (m[b + 1]! * x + m[b + 5]! * y + m[b + 9]! * z + m[b + 13]!);
      pz += s * (m[b + 2]! * x + m[b + 6]! * y + m[b + 10]! * z + m[b + 14]!);
      qx += s * (m[b]! * nx + m[b + 4]! * ny + m[b + 8]! * nz);
      qy += s * (m[b + 1]! * nx + m[b + 5]! * ny + m[b + 9]! * nz);
      qz += s * (m[b + 2]! * nx + m[b + 6]! * ny + m[b + 10]! * nz);
    }
    places[i] = px;
    places[i + 1] = py;
    places[i + 2] = pz;
    normals[i] = qx;
    normals[i + 1] = qy;
    normals[i + 2] = qz;
  }
}
