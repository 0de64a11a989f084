/** The ground of a scene: its marks, and its places with what stands there. */

import { DARK } from "../dom/wishes.ts";
import * as THREE from "three";
import type { GroundShape, PlaceShape } from "../api/types.ts";
import { stageColours } from "./colours.ts";
import type { Screen } from "./screen.ts";

export interface CourtPlan {
  ground: GroundShape;
  places: readonly PlaceShape[];
}

type Spot = readonly [x: number, z: number];

/** Width of a line and its height above the ground, metres. FIBA's 5 cm are not seen from far away. */
const LINE = { width: 0.08, height: 0.004 };
/** Thickness of the edge of a place with a size, metres. */
const THICK = 0.02;
/** Half the side of the mark of a place, metres. */
const PLACE = 0.15;

/** Flat strips along lines of points. */
function strips(lines: readonly (readonly Spot[])[]): THREE.BufferGeometry {
  const corners: number[] = [];
  for (const line of lines) {
    for (let i = 1; i < line.length; i += 1) {
      const [a, b] = [line[i - 1]!, line[i]!];
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const half = LINE.width / 2 / length;
      const [nx, nz] = [-(b[1] - a[1]) * half, (b[0] - a[0]) * half];
      const at = (p: Spot, side: number): number[] => [p[0] + side * nx, LINE.height, p[1] + side * nz];
      corners.push(...at(a, 1), ...at(b, 1), ...at(a, -1), ...at(b, 1), ...at(b, -1), ...at(a, -1));
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  return geometry;
}

/** The edge of the ground. */
function edge({ width, length, left, back }: GroundShape): Spot[] {
  return [
    [left, back],
    [left + width, back],
    [left + width, back + length],
    [left, back + length],
    [left, back],
  ];
}

const square = ([x, z]: Spot): Spot[] => [
  [x - PLACE, z - PLACE],
  [x + PLACE, z - PLACE],
  [x + PLACE, z + PLACE],
  [x - PLACE, z + PLACE],
  [x - PLACE, z - PLACE],
];

/** The edge of a place with a size: a level ring, or an upright rectangle, at its height. */
function outline({ at, height, width, tall }: PlaceShape, paint: THREE.Material): THREE.Object3D {
  if (tall > 0) {
    const drawn = new THREE.LineSegments(
      new THREE.EdgesGeometry(new THREE.PlaneGeometry(width, tall)),
      paint,
    );
    drawn.position.set(at[0], height, at[1]);
    return drawn;
  }
  const ring = new THREE.Mesh(new THREE.TorusGeometry(width / 2, THICK, 8, 32), paint);
  ring.rotation.x = Math.PI / 2;
  ring.position.set(at[0], height, at[1]);
  return ring;
}

/** Marks that stand above the ground, as lines. */
function raised({ own, marks }: GroundShape): THREE.BufferGeometry {
  const ends: number[] = [];
  for (const mark of own ? [] : marks) {
    if (mark.every(([, y]) => y === 0)) continue;
    for (let i = 1; i < mark.length; i += 1) ends.push(...mark[i - 1]!, ...mark[i]!);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  return geometry;
}

/** Draw grounds into a screen; the figures and the ball play on them. */
export function makeCourt(screen: Screen) {
  const group = new THREE.Group();
  screen.extras.add(group);
  let plan: CourtPlan | null = null;

  function clear(): void {
    for (const child of [...group.children] as THREE.Mesh[]) {
      group.remove(child);
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
    }
  }

  function draw(): void {
    clear();
    screen.redraw();
    if (!plan) return;
    const colours = stageColours();
    const { ground, places } = plan;
    const named = places.filter((one) => !one.given && !one.width).map((one) => square(one.at));
    const flat = (ground.own ? [] : ground.marks).filter((mark) => mark.every(([, y]) => y === 0));
    const lines = [edge(ground), ...flat.map((mark) => mark.map(([x, , z]): Spot => [x, z])), ...named];
    const paint = new THREE.MeshBasicMaterial({
      color: colours.court,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const floor = new THREE.Mesh(strips(lines), paint);
    floor.renderOrder = -1; // with the lines of the ground, below bodies
    group.add(floor);
    const ring = new THREE.MeshBasicMaterial({ color: colours.contact });
    for (const one of places) if (one.width > 0) group.add(outline(one, ring));
    group.add(new THREE.LineSegments(raised(ground), new THREE.LineBasicMaterial({ color: colours.court })));
    for (const child of group.children) child.frustumCulled = false;
  }

  DARK.addEventListener("change", draw);
  return {
    /** Draw a ground; null: none. */
    show(next: CourtPlan | null): void {
      plan = next;
      draw();
    },
    close(): void {
      DARK.removeEventListener("change", draw);
      clear();
    },
  };
}
