/** The selected element of the board: its settings, and why it cannot be played. */

import { named, numberField } from "../../dom/fields.ts";
import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import { nameOf } from "./drawing.ts";
import type { Selection } from "./edits.ts";
import { groundNow, linkOf, lookOf, needsOther, styleOf } from "./verbs.ts";
import type { BoardReply, DiagramShape, ElementShape, PlayerShape } from "../../api/types.ts";

export interface PanelActions {
  changeElement(index: number, change: Partial<ElementShape>): void;
  changePlayer(name: string, change: Partial<PlayerShape>): void;
  changeBall(name: string): void;
  /** Add an action of a player, after one of the player's actions or after all of them. */
  addElement(player: string, kind: string, after: number | null): void;
  select(selection: Selection): void;
  remove(): void;
}

const ADD = "an action…";

interface Choice {
  id: string;
  label: string;
  value: string;
  options: readonly string[];
  choose(value: string): void;
}

function choice({ id, label, value, options, choose }: Choice): HTMLElement[] {
  const select = h(
    "select.field",
    { id, on: { change: () => choose(select.value) } },
    options.map((one) =>
      h("option", { value: one, selected: one === value }, one.replace("_", " ") || "nobody"),
    ),
  );
  return named(label, select);
}

function wholeNumber(
  id: string,
  label: string,
  value: number,
  least: number,
  set: (value: number) => void,
): HTMLElement[] {
  const input = numberField(id, least, {
    value,
    on: { change: () => Number.isInteger(input.valueAsNumber) && set(Math.max(input.valueAsNumber, least)) },
  });
  return named(label, input);
}

function reasonLine(reason: string | null): HTMLElement | null {
  return reason ? h("p.board-reason", { role: "status" }, reason) : null;
}

function removeButton(what: string, remove: () => void): HTMLElement {
  return button("remove", `Remove ${what}`, remove);
}

function elementPanel(
  diagram: DiagramShape,
  board: BoardReply | null,
  index: number,
  kinds: readonly string[],
  actions: PanelActions,
): HTMLElement {
  const element = diagram.elements[index]!;
  const change = (changes: Partial<ElementShape>): void => actions.changeElement(index, changes);
  const others = diagram.players.map((one) => one.name).filter((name) => name !== element.player);
  return h(
    "section.board-selected",
    { "aria-label": "Selected action" },
    h("h2", nameOf(diagram, index)),
    reasonLine(board?.elements.find((one) => one.element === index)?.reason ?? null),
    h(
      "div.form-grid",
      wholeNumber("element-step", "Step", element.step, 1, (step) => change({ step })),
      lookOf(element.kind) === "give"
        ? wholeNumber("element-caught", "Caught at", Math.max(element.caught, element.step), 1, (caught) =>
            change({ caught: caught > element.step ? caught : 0 }),
          )
        : null,
      needsOther(element.kind)
        ? choice({
            id: "element-other",
            label: linkOf(element.kind),
            value: element.other,
            options: others,
            choose: (other) => change({ other }),
          })
        : null,
      choice({
        id: "element-then",
        label: `Then ${element.player} does`,
        value: "",
        options: [ADD, ...kinds],
        choose: (kind) => kind !== ADD && actions.addElement(element.player, kind, index),
      }),
    ),
    element.via.length ? button("link", "Make the path straight", () => change({ via: [] })) : null,
    removeButton("this action", actions.remove),
  );
}

function playerPanel(
  diagram: DiagramShape,
  board: BoardReply | null,
  name: string,
  kinds: readonly string[],
  actions: PanelActions,
): HTMLElement {
  const player = diagram.players.find((one) => one.name === name)!;
  const facts = board?.players.find((one) => one.name === name);
  const opponents = diagram.players.filter((one) => one.team !== player.team).map((one) => one.name);
  return h(
    "section.board-selected",
    { "aria-label": "Selected player" },
    h("h2", `${name}, ${player.team}`),
    reasonLine(facts?.reason ?? null),
    facts?.shortest.length ? h("p.muted", `shortest play: ${facts.shortest.join(", ")}`) : null,
    h(
      "div.form-grid",
      choice({
        id: "player-action",
        label: "Add",
        value: "",
        options: [ADD, ...kinds],
        choose: (kind) => kind !== ADD && actions.addElement(name, kind, null),
      }),
      styleOf(player.team) === "second"
        ? choice({
            id: "player-guards",
            label: "Guards",
            value: player.guards,
            options: ["", ...opponents],
            choose: (guards) => actions.changePlayer(name, { guards }),
          })
        : null,
    ),
    groundNow().object
      ? h(
          "label.check",
          h("input", {
            type: "checkbox",
            checked: board?.holder === name,
            on: {
              change: (event: Event) =>
                actions.changeBall((event.currentTarget as HTMLInputElement).checked ? name : ""),
            },
          }),
          `has the ${groundNow().object} at the start`,
        )
      : null,
    removeButton(name, actions.remove),
  );
}

/** What the grammar makes of a board on which no action is drawn. */
function derived(board: BoardReply | null): HTMLElement | null {
  const rows = (board?.players ?? []).filter((one) => one.shortest.length > 0);
  if (rows.length === 0) return null;
  return h(
    "ul.plain.small",
    { "aria-label": "By the grammar" },
    rows.map((one) => h("li", h("b", one.name), `, as long as nothing is drawn: ${one.shortest.join(", ")}`)),
  );
}

function overview(diagram: DiagramShape, board: BoardReply | null, actions: PanelActions): HTMLElement {
  const order = diagram.elements
    .map((_, i) => i)
    .sort((a, b) => diagram.elements[a]!.step - diagram.elements[b]!.step || a - b);
  return h(
    "section.board-selected",
    { "aria-label": "Actions in order" },
    h("h2", "Actions"),
    order.length
      ? h(
          "ul.plain.board-list",
          order.map((index) => {
            const reason = board?.elements.find((one) => one.element === index)?.reason ?? null;
            const point = diagram.elements[index]!.to ? ("end" as const) : null;
            return h(
              "li",
              { class: reason ? "infeasible" : "" },
              button("link", nameOf(diagram, index), () => actions.select({ what: "element", index, point })),
              reason ? h("span.board-reason", ` ${reason}`) : null,
            );
          }),
        )
      : h("p.muted", "Choose an action, then drag it from a player on the board."),
    order.length ? null : derived(board),
  );
}

/** The panel beside the board. */
export function panelOf(
  diagram: DiagramShape,
  board: BoardReply | null,
  selection: Selection,
  kinds: readonly string[],
  actions: PanelActions,
): HTMLElement {
  if (selection?.what === "element" && diagram.elements[selection.index]) {
    return elementPanel(diagram, board, selection.index, kinds, actions);
  }
  if (selection?.what === "player" && diagram.players.some((one) => one.name === selection.name)) {
    return playerPanel(diagram, board, selection.name, kinds, actions);
  }
  return overview(diagram, board, actions);
}
