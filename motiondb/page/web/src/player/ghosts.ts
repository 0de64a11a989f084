/** Boxes for things that were not captured: a seat, steps, a bar. */

import { DARK } from "../dom/wishes.ts";
import * as THREE from "three";
import type { Ghost } from "../api/types.ts";
import { stageColours } from "./colours.ts";
import { seenAt } from "./motion.ts";
import type { Screen } from "./screen.ts";

const OPACITY = 0.3;

function boxOf({ centre, size }: Ghost, colour: THREE.Color): THREE.Object3D {
  const shape = new THREE.BoxGeometry(...size);
  const paint = new THREE.MeshBasicMaterial({
    color: colour,
    transparent: true,
    opacity: OPACITY,
    depthWrite: false,
  });
  const edges = new THREE.LineSegments(
    new THREE.EdgesGeometry(shape),
    new THREE.LineBasicMaterial({ color: colour }),
  );
  const drawn = new THREE.Group();
  drawn.add(new THREE.Mesh(shape, paint), edges);
  drawn.position.set(...centre);
  return drawn;
}

/** Draw boxes into a screen while they are needed. */
export function makeGhosts(screen: Screen) {
  const group = new THREE.Group();
  screen.extras.add(group);
  let ghosts: readonly Ghost[] = [];

  function clear(): void {
    for (const box of [...group.children]) {
      group.remove(box);
      for (const part of box.children as THREE.Mesh[]) {
        part.geometry.dispose();
        (part.material as THREE.Material).dispose();
      }
    }
  }

  function tell(time: number): void {
    const seen = seenAt(ghosts, time);
    group.children.forEach((box, i) => (box.visible = seen[i]!));
    screen.canvas.dataset["ghosts"] = String(seen.filter(Boolean).length);
  }

  function draw(): void {
    clear();
    const { contact } = stageColours();
    for (const ghost of ghosts) group.add(boxOf(ghost, contact));
    tell(screen.playback.time);
    screen.redraw();
  }

  DARK.addEventListener("change", draw);
  screen.onTime(tell);
  return {
    show(next: readonly Ghost[]): void {
      ghosts = next;
      draw();
    },
    close(): void {
      DARK.removeEventListener("change", draw);
      clear();
    },
  };
}
