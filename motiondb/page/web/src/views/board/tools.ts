/** The tools above the board: select, place a player, draw an action. */

import { fill, h } from "../../dom/element.ts";
import type { BoardKinds } from "../../api/types.ts";
import type { Team } from "./spot.ts";

export interface Tools {
  readonly element: HTMLElement;
  /** The kind of action that is drawn; "" while things are selected and moved. */
  readonly tool: string;
  /** The team of the player that is placed; null otherwise. */
  readonly team: Team | null;
  setKinds(kinds: BoardKinds): void;
  clear(): void;
}

const GROUPS: readonly [string, readonly string[]][] = [
  ["Move", ["move", "walk", "run", "cut", "dribble"]],
  ["Ball", ["pass", "shoot", "layup"]],
  ["Trick", ["feint", "fake", "pivot_left", "pivot_right"]],
  ["Block", ["screen", "guard", "block"]],
];

export function makeTools(change: () => void): Tools {
  let chosen = "";
  let kinds: BoardKinds = { kinds: [], teams: [], grammars: [] };
  const element = h("div", { class: "board-tools", role: "toolbar", "aria-label": "Tools of the board" });

  function button(value: string, label: string, title: string): HTMLElement {
    return h(
      "button",
      {
        class: "button plain",
        type: "button",
        title,
        "aria-pressed": String(chosen === value),
        "data-tool": value,
        on: {
          click: () => {
            chosen = chosen === value ? "" : value;
            draw();
            change();
          },
        },
      },
      label,
    );
  }

  function draw(): void {
    fill(
      element,
      h("div", { class: "row" }, button("", "Select", "Select and move (Escape)")),
      h(
        "div",
        { class: "row", role: "group", "aria-label": "Players" },
        kinds.teams.map((team) =>
          button(`team:${team}`, `+ ${team}`, `Click on the court to place a player of ${team}`),
        ),
      ),
      GROUPS.map(([title, members]) =>
        h(
          "div",
          { class: "row", role: "group", "aria-label": title },
          members
            .filter((kind) => kinds.kinds.includes(kind))
            .map((kind) =>
              button(kind, kind.replace("_", " "), `Drag from a player to draw: ${kind.replace("_", " ")}`),
            ),
        ),
      ),
    );
  }

  return {
    element,
    get tool() {
      return chosen;
    },
    get team() {
      return chosen.startsWith("team:") ? (chosen.slice(5) as Team) : null;
    },
    setKinds(known) {
      kinds = known;
      draw();
    },
    clear() {
      chosen = "";
      draw();
    },
  };
}
