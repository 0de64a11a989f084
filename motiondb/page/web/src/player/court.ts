/** The ground of a scene: the lines of a court with its basket, or a field with its places. */

import { DARK } from "../dom/wishes.ts";
import * as THREE from "three";
import type { CourtShape, PlaceShape } from "../api/types.ts";
import { courtLines } from "../parts/court.ts";
import { stageColours } from "./colours.ts";
import type { Screen } from "./screen.ts";

export interface CourtPlan {
  court: CourtShape;
  places: readonly PlaceShape[];
}

export interface Court {
  /** Draw a ground; null: none. */
  show(plan: CourtPlan | null): void;
  close(): void;
}

type Spot = readonly [x: number, z: number];

/** Width of a line and its height above the ground, metres. FIBA's 5 cm are not seen from far away. */
const LINE = { width: 0.08, height: 0.004 };
/** The basket, metres (FIBA, article 2 and its equipment): ring, board, and the pole outside the court. */
const RING = { radius: 0.225, height: 3.05, thick: 0.02 };
const BOARD = { width: 1.8, height: 1.05, bottom: 2.9, behind: 0.375 };
const NET = { length: 0.42, radius: 0.14, cords: 12 };
const POLE = { thick: 0.09, outside: 0.5 };
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
function edge({ width, length, behind_rim }: CourtShape): Spot[] {
  const [x, back, front] = [width / 2, -behind_rim, length - behind_rim];
  return [
    [-x, back],
    [x, back],
    [x, front],
    [-x, front],
    [-x, back],
  ];
}

const square = ([x, z]: Spot): Spot[] => [
  [x - PLACE, z - PLACE],
  [x + PLACE, z - PLACE],
  [x + PLACE, z + PLACE],
  [x - PLACE, z + PLACE],
  [x - PLACE, z - PLACE],
];

/** The cords of the net, from the ring down. */
function net(): THREE.BufferGeometry {
  const ends: number[] = [];
  for (let i = 0; i < NET.cords; i += 1) {
    for (const turn of [1, -1]) {
      const [a, b] = [(2 * Math.PI * i) / NET.cords, (2 * Math.PI * (i + turn)) / NET.cords];
      ends.push(RING.radius * Math.cos(a), RING.height, RING.radius * Math.sin(a));
      ends.push(NET.radius * Math.cos(b), RING.height - NET.length, NET.radius * Math.sin(b));
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  return geometry;
}

function basket(court: CourtShape, ring: THREE.Material, frame: THREE.Material): THREE.Object3D[] {
  const hoop = new THREE.Mesh(new THREE.TorusGeometry(RING.radius, RING.thick, 8, 32), ring);
  hoop.rotation.x = Math.PI / 2;
  hoop.position.y = RING.height;
  const neck = new THREE.Mesh(new THREE.BoxGeometry(0.08, 0.04, BOARD.behind - RING.radius), ring);
  neck.position.set(0, RING.height, -(BOARD.behind + RING.radius) / 2);
  const middle = BOARD.bottom + BOARD.height / 2;
  const rectangle = (width: number, height: number, y: number): THREE.Object3D => {
    const outline = new THREE.EdgesGeometry(new THREE.PlaneGeometry(width, height));
    const drawn = new THREE.LineSegments(outline, frame);
    drawn.position.set(0, y, -BOARD.behind);
    return drawn;
  };
  const glass = new THREE.Mesh(
    new THREE.PlaneGeometry(BOARD.width, BOARD.height),
    new THREE.MeshBasicMaterial({
      color: (frame as THREE.LineBasicMaterial).color,
      transparent: true,
      opacity: 0.28,
      depthWrite: false,
      side: THREE.DoubleSide,
    }),
  );
  glass.position.set(0, middle, -BOARD.behind);
  const foot = -court.behind_rim - POLE.outside;
  const pole = new THREE.Mesh(new THREE.CylinderGeometry(POLE.thick, POLE.thick, middle, 10), frame);
  pole.position.set(0, middle / 2, foot);
  const reach = -BOARD.behind - foot;
  const arm = new THREE.Mesh(new THREE.BoxGeometry(POLE.thick, POLE.thick, reach), frame);
  arm.position.set(0, middle, foot + reach / 2);
  return [
    hoop,
    neck,
    rectangle(BOARD.width, BOARD.height, middle),
    rectangle(0.59, 0.45, RING.height + 0.225),
    glass,
    pole,
    arm,
    new THREE.LineSegments(net(), frame),
  ];
}

/** Draw grounds into a screen; the figures and the ball play on them. */
export function makeCourt(screen: Screen): Court {
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
    const { court, places } = plan;
    const named = places.filter((one) => one.name !== "rim").map((one) => square(one.at));
    const lines = [edge(court), ...(court.lines ? courtLines(court) : []), ...named];
    const paint = new THREE.MeshBasicMaterial({
      color: colours.court,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const floor = new THREE.Mesh(strips(lines), paint);
    floor.renderOrder = -1; // with the lines of the ground, below bodies
    group.add(floor);
    if (court.lines) {
      const ring = new THREE.MeshBasicMaterial({ color: colours.contact });
      group.add(...basket(court, ring, new THREE.MeshBasicMaterial({ color: colours.court })));
    }
    for (const child of group.children) child.frustumCulled = false;
  }

  DARK.addEventListener("change", draw);
  return {
    show(next) {
      plan = next;
      draw();
    },
    close() {
      DARK.removeEventListener("change", draw);
      clear();
    },
  };
}
