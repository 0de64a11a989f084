/** The tools above the board: select, place a player, draw an action. */

import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import type { Ground } from "../../api/types.ts";
import type { Team } from "./spot.ts";
import { groundNow } from "./verbs.ts";

const GROUPS: readonly [string, readonly string[]][] = [
  ["Go", ["way", "wave"]],
  ["Give", ["give", "send"]],
  ["Together", ["link"]],
  ["Do", ["act"]],
];

export function makeTools(change: () => void) {
  let chosen = "";
  let ground: Ground = groundNow();
  const element = h("div.board-tools", { role: "toolbar", "aria-label": "Tools of the board" });

  function tool(value: string, label: string, title: string): HTMLElement {
    return button(
      "plain",
      label,
      () => {
        chosen = chosen === value ? "" : value;
        draw();
        change();
      },
      { title, "aria-pressed": String(chosen === value), "data-tool": value },
    );
  }

  function draw(): void {
    fill(
      element,
      h("div.row", tool("", "Select", "Select and move (Escape)")),
      h(
        "div.row",
        { role: "group", "aria-label": "Players" },
        ground.teams.map((team) =>
          tool(`team:${team}`, `+ ${team}`, `Click on the ground to place one: ${team}`),
        ),
      ),
      GROUPS.map(([title, looks]) => {
        const offered = ground.verbs.filter((one) => one.declared || ground.verbs.every((v) => !v.declared));
        const known = offered.filter((one) => looks.includes(one.look)).map((one) => one.name);
        if (known.length === 0) return null;
        return h(
          "div.row",
          { role: "group", "aria-label": title },
          known.map((kind) =>
            tool(
              kind,
              kind.replace("_", " "),
              `Drag from a player, or from the end of a path, to draw: ${kind.replace("_", " ")}`,
            ),
          ),
        );
      }),
    );
  }

  return {
    element,
    /** The kind of action that is drawn; "" while things are selected and moved. */
    get tool() {
      return chosen;
    },
    /** The team of the player that is placed; null otherwise. */
    get team() {
      return chosen.startsWith("team:") ? (chosen.slice(5) as Team) : null;
    },
    /** Offer what the grammar of a diagram allows. */
    setGround(next: Ground): void {
      if (next.grammar === ground.grammar) return;
      ground = next;
      chosen = "";
      draw();
    },
    clear(): void {
      chosen = "";
      draw();
    },
  };
}

export type Tools = ReturnType<typeof makeTools>;
