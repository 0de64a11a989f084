/** The path of the root in the scene: coloured discs on the ground, and spheres over the region. */

import * as THREE from "three";
import type { Screen } from "../../player/screen.ts";
import type { TerminalColours } from "./colours.ts";
import { cutPath, spaced, timesOf } from "./layout.ts";
import type { SequenceReply } from "../../api/types.ts";
import type { Spot } from "./selection.ts";

/** Radius of a disc and distance between discs, metres. Chosen by eye: they look like one line. */
const DISC = { radius: 0.045, apart: 0.03, height: 0.006 };
/** The same for the translucent spheres over the region. */
const SPHERE = { radius: 0.085, apart: 0.2, opacity: 0.45 };

type Dots = THREE.InstancedMesh<THREE.BufferGeometry, THREE.MeshBasicMaterial>;

function dots(
  geometry: THREE.BufferGeometry,
  spots: readonly Spot[],
  height: number,
  opacity: number,
  colourOf: (i: number) => readonly [number, number, number],
): Dots {
  const material = new THREE.MeshBasicMaterial({ transparent: true, opacity, depthWrite: false });
  const mesh = new THREE.InstancedMesh(geometry, material, spots.length);
  const place = new THREE.Matrix4();
  const colour = new THREE.Color();
  spots.forEach(([x, z], i) => {
    mesh.setMatrixAt(i, place.makeTranslation(x, height, z));
    mesh.setColorAt(i, colour.setRGB(...(colourOf(i) as [number, number, number])));
  });
  mesh.frustumCulled = false;
  return mesh;
}

/** Draw the path of a sequence into a screen. */
export function makeRibbon(screen: Screen) {
  const disc = new THREE.CircleGeometry(DISC.radius, 14);
  disc.rotateX(-Math.PI / 2);
  const sphere = new THREE.SphereGeometry(SPHERE.radius, 14, 10);
  const path = new THREE.Group();
  const region = new THREE.Group();
  screen.extras.add(path, region);
  let shown: { sequence: SequenceReply; colours: TerminalColours } | null = null;

  function clear(group: THREE.Group): void {
    for (const child of [...group.children] as Dots[]) {
      group.remove(child);
      child.material.dispose();
      child.dispose();
    }
  }

  /** The spots of some terminals, each with the number of its terminal. */
  function along(start: number, end: number, apart: number): { spot: Spot; at: number }[] {
    const { sequence } = shown!;
    return sequence.strip
      .slice(start, end)
      .flatMap((item) =>
        spaced(cutPath(sequence.path, item.start, item.end), apart).map((spot) => ({ spot, at: item.at })),
      );
  }

  function draw(group: THREE.Group, start: number, end: number, look: typeof DISC | typeof SPHERE): void {
    clear(group);
    const { sequence, colours } = shown!;
    const found = along(start, end, look.apart);
    const flat = "height" in look;
    group.add(
      dots(
        flat ? disc : sphere,
        found.map(({ spot }) => spot),
        flat ? look.height : SPHERE.radius,
        flat ? 1 : SPHERE.opacity,
        (i) => colours.rgb(sequence.strip[found[i]!.at]!.terminal),
      ),
    );
    screen.redraw();
  }

  return {
    show(sequence: SequenceReply, colours: TerminalColours): void {
      shown = { sequence, colours };
      draw(path, 0, sequence.strip.length, DISC);
      clear(region);
    },
    mark(part: readonly [start: number, end: number] | null): void {
      if (!shown) return;
      if (!part) {
        clear(region);
        return screen.redraw();
      }
      const [from, to] = timesOf(shown.sequence.strip, ...part);
      if (to > from) draw(region, ...part, SPHERE);
      else clear(region);
      screen.redraw();
    },
    close(): void {
      clear(path);
      clear(region);
      disc.dispose();
      sphere.dispose();
    },
  };
}

export type Ribbon = ReturnType<typeof makeRibbon>;
