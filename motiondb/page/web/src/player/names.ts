/** The names of the figures of a player, over their heads. */

import type { BodyTrack, Track } from "../api/container.ts";
import { fill, h } from "../dom/element.ts";
import { pictureOf } from "./flat.ts";
import { poseAt } from "./motion.ts";
import type { Screen } from "./screen.ts";
import { rolesOf } from "./cast_colours.ts";

/** Styles of the names of the first two roles. */
const STYLES = ["first", "second"];

/** Metres above the top of a head. */
const ABOVE = 0.22;

interface Named {
  label: HTMLElement;
  track: BodyTrack;
  /** The number of the point at the top of the head, or of the root. */
  point: number;
  pose: Float32Array;
  shift: readonly [number, number];
}

/** Make the layer of names of a screen; it lies over its canvas. */
export function makeNames(screen: Screen) {
  const element = h("div.player-names", { "aria-hidden": "true" });
  let named: Named[] = [];

  screen.onDraw(() => {
    const { canvas, orbit, playback } = screen;
    const picture = pictureOf(orbit, canvas.clientWidth, canvas.clientHeight);
    for (const { label, track, point, pose, shift } of named) {
      poseAt(track.motion, playback.time, pose);
      const [x, y, z] = [pose[3 * point]!, pose[3 * point + 1]!, pose[3 * point + 2]!];
      const [right, down, depth] = picture([x + shift[0], y + ABOVE, z + shift[1]]);
      label.style.transform = `translate(${right.toFixed(1)}px, ${down.toFixed(1)}px) translate(-50%, -100%)`;
      label.style.zIndex = String(Math.round(1000 / depth)); // the nearer lies above
      label.hidden = depth <= 0.06;
    }
  });

  return {
    element,
    /** Name the bodies of some tracks; one alone needs no name. */
    show(tracks: readonly Track[], shifts?: readonly (readonly [number, number])[]): void {
      const bodies = tracks.filter((track): track is BodyTrack => track.kind === "body");
      named = (bodies.length > 1 ? bodies : []).map((track, i) => ({
        label: h(
          "span",
          { class: `player-name ${STYLES[rolesOf(bodies).indexOf(track.team ?? "")] ?? ""}` },
          track.name,
        ),
        track,
        point: Math.max(track.motion.points.indexOf("head_end"), 0),
        pose: new Float32Array(track.motion.points.length * 3),
        shift: shifts?.[i] ?? [0, 0],
      }));
      fill(
        element,
        named.map((one) => one.label),
      );
      screen.redraw();
    },
  };
}

export type Names = ReturnType<typeof makeNames>;
