/** The list of the player's keys. */

import { button } from "../dom/button.ts";
import { h } from "../dom/element.ts";

const KEYS: readonly [string, string][] = [
  ["Space", "play, pause"],
  ["← →", "one frame back, forward"],
  ["↑ ↓", "faster, slower"],
  ["Home End", "start, end of the played part"],
  ["L", "loop"],
  ["F", "follow the figure"],
  ["G", "grid"],
  ["T", "trails of hands and feet"],
  ["C", "feet on the ground"],
  ["V", "go around them"],
  ["R", "see everything"],
  ["1 2 3", "from the front, the side, above"],
  ["A D W S", "turn the camera"],
  ["+ −", "nearer, farther"],
  [", .", "move the camera left, right"],
];

/** Open the list over a player. */
export function showKeys(player: HTMLElement): void {
  const dialog: HTMLDialogElement = h(
    "dialog.dialog.keys",
    { "aria-label": "Keys of the player", on: { close: () => dialog.remove() } },
    h("h2", "Keys of the player"),
    h(
      "dl",
      KEYS.map(([keys, action]) => h("div", h("dt", keys), h("dd", action))),
    ),
    h(
      "p.muted",
      "The keys work while the picture has the focus. Drag to turn the camera, drag with Shift to move it, and use the wheel to zoom.",
    ),
    button("main", "Close", () => dialog.close(), { autofocus: true }),
  );
  player.append(dialog);
  dialog.showModal();
}
