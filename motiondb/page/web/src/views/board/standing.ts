/** The people of a diagram as they stand before a scene is made: at ease, facing what they play for. */

import type { DiagramShape } from "../../api/types.ts";
import type { Track } from "../../api/container.ts";
import { POINTS, restOf } from "../../player/mannequin/bones.ts";
import type { Spot } from "./spot.ts";

/** Where a hanging arm has its points, from the shoulder of the left side, metres. */
const HANGING: Readonly<Record<string, readonly [number, number, number]>> = {
  elbow: [0.04, -0.27, -0.02],
  wrist: [0.05, -0.51, 0.05],
  hand_end: [0.04, -0.67, 0.09],
};
/** Height of the pelvis of who stands, metres. */
const PELVIS = 0.93;
/** Where a held object is: beside, above, ahead of who holds it, metres; and its radius. */
const HELD = { aside: 0.28, up: 0.95, ahead: 0.25, radius: 0.12 };

function place(point: string): [number, number, number] {
  const hanging = HANGING[point.slice(2)];
  const [x, y, z] = restOf(hanging ? `${point[0]}_shoulder` : point);
  if (!hanging) return [x, y, z];
  const side = point.startsWith("r_") ? -1 : 1;
  return [x + side * hanging[0], y + hanging[1], z + hanging[2]];
}

const REST = POINTS.map(place);

/** Whom or what a player faces: who is guarded, the first place with a size, or the middle of all. */
function faced(diagram: DiagramShape, name: string): Spot {
  const self = diagram.players.find((one) => one.name === name)!;
  const guarded = diagram.players.find((one) => one.name === self.guards);
  const target = diagram.places.find((one) => one.width > 0);
  if (guarded) return guarded.at;
  if (target) return target.at;
  const others = diagram.players.filter((one) => one !== self);
  const mean = (axis: 0 | 1): number => others.reduce((sum, one) => sum + one.at[axis], 0) / others.length;
  return others.length ? [mean(0), mean(1)] : [self.at[0], self.at[1] + 1];
}

/** One frame of everybody, and of the object beside who holds it. */
export function standing(diagram: DiagramShape): Track[] {
  return diagram.players.flatMap(({ name, team, at }): Track[] => {
    const [tx, tz] = faced(diagram, name);
    const heading = Math.atan2(tx - at[0], tz - at[1]);
    const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
    const put = ([x, y, z]: readonly [number, number, number]): number[] => [
      at[0] + x * cos + z * sin,
      y,
      at[1] - x * sin + z * cos,
    ];
    const shared = { fps: 30, frames: 1, start: 0 };
    const body: Track = {
      kind: "body",
      name,
      ref: null,
      team,
      motion: {
        ...shared,
        points: [...POINTS],
        parents: POINTS.map(() => -1),
        radii: POINTS.map(() => 0.03),
        positions: new Float32Array(REST.flatMap(([x, y, z]) => put([x, y + PELVIS, z]))),
        contacts: null,
        moment: null,
      },
    };
    if (diagram.ball !== name) return [body];
    const { aside, up, ahead, radius } = HELD;
    const positions = new Float32Array(put([-aside, up, ahead]));
    return [body, { kind: "ball", name: "ball", motion: { ...shared, positions, radius } }];
  });
}
