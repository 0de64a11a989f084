/** The players and the ball of the scene, moving on the board while it plays. */

import type { Track } from "../../api/container.ts";
import { fill, svg } from "../../dom/element.ts";
import { poseAt } from "../../player/motion.ts";
import { RADIUS } from "./strokes.ts";
import { styleOf } from "./verbs.ts";
import type { Spot } from "./spot.ts";

export interface Token {
  name: string;
  /** The role of a player; "ball" for the object. */
  team: string;
  at: Spot;
}

/** Where everybody is at a time of a scene. */
export function tokensAt(tracks: readonly Track[], time: number): Token[] {
  return tracks
    .filter((track) => track.motion.frames > 0)
    .map((track) => {
      const points = track.kind === "body" ? track.motion.points.length : 1;
      const pose = new Float32Array(points * 3);
      poseAt(track.motion, time, pose);
      const team = track.kind === "body" ? (track.team ?? "player") : "ball";
      return { name: track.name, team, at: [pose[0]!, pose[2]!] };
    });
}

/** Make the layer of tokens of a board. */
export function makeTokens() {
  const element = svg("g.board-tokens", { "aria-hidden": "true" });
  let drawn = "";
  return {
    element,
    show(tokens: readonly Token[]): void {
      const cast = tokens.map((one) => `${one.team} ${one.name}`).join("|");
      if (cast !== drawn) {
        drawn = cast;
        const mark = ({ name, team }: Token): SVGElement =>
          team === "ball"
            ? svg("g.board-token.ball", svg("circle", { r: 0.18 }))
            : svg(
                "g",
                { class: `board-token ${styleOf(team)}`, "data-token": name },
                svg("circle", { r: RADIUS }),
                svg("text", { y: 0.13 }, name),
              );
        fill(element, tokens.map(mark));
      }
      tokens.forEach(({ at: [x, z] }, i) =>
        element.children[i]!.setAttribute("transform", `translate(${x.toFixed(3)} ${z.toFixed(3)})`),
      );
    },
  };
}
