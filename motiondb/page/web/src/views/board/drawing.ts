/** The board: the ground, players and lines as SVG, moved with the pointer or the keyboard. */

import { fill, h, svg } from "../../dom/element.ts";
import { placeBefore, placeOf, type Selection } from "./edits.ts";
import { groundLines } from "../../parts/court.ts";
import { endsAtPlace, linkOf, needsOther, styleOf } from "./verbs.ts";
import { RADIUS, strokeOf, type Stroke } from "./strokes.ts";
import type { BoardReply, DiagramShape, PlaceShape, PlayerShape } from "../../api/types.ts";
import { makeTokens, type Token } from "./tokens.ts";
import type { Spot } from "./spot.ts";

export interface DrawingActions {
  select(selection: Selection): void;
  /** Something moves; `done` when the pointer is released or a key was pressed. */
  move(selection: Selection, to: Spot, done: boolean): void;
  /** A line was drawn from a player to a place, perhaps onto another player; `after` is the action at
   * whose end it began. */
  draw(player: string, to: Spot, other: string | null, after: number | null): void;
  /** A click on the empty ground. */
  place(at: Spot): void;
  remove(): void;
  /** Add a point to the path of an element. */
  bend(index: number, at: Spot): void;
}

const MARGIN = 0.6;
/** Metres that an arrow key moves something by; with Shift. */
const STEP = { plain: 0.1, shift: 0.5 };
const ARROWS: Record<string, Spot> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

const text = (points: readonly Spot[]): string =>
  points.map(([x, z]) => `${x.toFixed(3)},${z.toFixed(3)}`).join(" ");

/** The description of an element, in words. */
export function nameOf({ elements }: DiagramShape, index: number): string {
  const { kind, step, player, other, target, link } = elements[index]!;
  const about = other || target ? ` ${link || linkOf(kind)} ${other || target}` : "";
  return `step ${step}: ${player} ${kind.replace("_", " ")}${about}`;
}

export function makeDrawing(actions: DrawingActions) {
  const element = h("div.board-court");
  let diagram: DiagramShape | null = null;
  let board: BoardReply | null = null;
  let selection: Selection = null;
  let tool = "";
  let picture: SVGSVGElement | null = null;
  let dragging: { selection: Selection; moved: boolean } | null = null;
  let drawn: { player: string; to: Spot; after: number | null } | null = null;
  const tokens = makeTokens();

  /** The position of a pointer on the ground. */
  function groundOf(event: PointerEvent | MouseEvent): Spot {
    const matrix = picture!.getScreenCTM()!.inverse();
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return [x, y];
  }

  function playerAt([x, z]: Spot, but: string): string | null {
    const spots = diagram!.players.map(({ name, at }) => ({ name, at }));
    for (const { player, to } of diagram!.elements) if (to) spots.push({ name: player, at: to });
    const apart = ({ at }: { at: Spot }): number => Math.hypot(at[0] - x, at[1] - z);
    const near = spots.filter((one) => one.name !== but && apart(one) < 2 * RADIUS);
    return near.sort((a, b) => apart(a) - apart(b))[0]?.name ?? null;
  }

  function reasonOf(index: number): string | null {
    return board?.elements.find((one) => one.element === index)?.reason ?? null;
  }

  const isSelected = (index: number): boolean => selection?.what === "element" && selection.index === index;

  function keys(event: KeyboardEvent, mine: Selection): void {
    const arrow = ARROWS[event.key];
    const place = placeOf(diagram!, mine);
    if (arrow && place) {
      const by = event.shiftKey ? STEP.shift : STEP.plain;
      actions.move(mine, [place[0] + arrow[0] * by, place[1] + arrow[1] * by], true);
    } else if (event.key === "Enter" || event.key === " ") actions.select(mine);
    else if (event.key === "Delete" || event.key === "Backspace") {
      actions.select(mine);
      actions.remove();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  function grip(mine: Selection): { [type: string]: (event: never) => void } {
    return {
      pointerdown: (event: PointerEvent) => {
        event.stopPropagation();
        const ends = mine?.what === "element" && mine.point === "end";
        if (tool && mine?.what === "player") drawn = { player: mine.name, to: groundOf(event), after: null };
        else if (tool && ends) {
          const { player } = diagram!.elements[mine.index]!;
          drawn = { player, to: groundOf(event), after: mine.index };
        } else dragging = { selection: mine, moved: false };
        picture!.setPointerCapture(event.pointerId);
      },
      keydown: (event: KeyboardEvent) => keys(event, mine),
    };
  }

  function playerMark(player: PlayerShape): SVGElement {
    const mine: Selection = { what: "player", name: player.name };
    const fault = board?.players.find((one) => one.name === player.name)?.reason ?? null;
    const chosen = selection?.what === "player" && selection.name === player.name;
    const reach = 0.62 * RADIUS;
    const cross = `M${-reach},${-reach}L${reach},${reach}M${-reach},${reach}L${reach},${-reach}`;
    return svg(
      "g",
      {
        class: `board-player ${styleOf(player.team)}${fault ? " infeasible" : ""}${chosen ? " chosen" : ""}`,
        transform: `translate(${player.at[0]} ${player.at[1]})`,
        tabindex: 0,
        role: "button",
        "aria-pressed": String(chosen),
        "data-player": player.name,
        "aria-label": `${player.name}, ${player.team}, at ${player.at[0]} ${player.at[1]}${fault ? `: ${fault}` : ""}`,
        on: grip(mine),
      },
      svg("title", fault ? `${player.name}: ${fault}` : player.name),
      svg("circle.board-disc", { r: RADIUS }),
      styleOf(player.team) === "second" ? svg("path.board-cross", { d: cross }) : null,
      svg(
        "text",
        styleOf(player.team) === "second" ? { x: 0.52, y: -0.3 } : { y: 0.13, class: "inside" },
        player.name,
      ),
    );
  }

  /** A player at the end of a path: the next action is drawn from here; it is dragged as the end. */
  function ghost(index: number): SVGElement | null {
    const { player, to } = diagram!.elements[index]!;
    const team = diagram!.players.find(({ name }) => name === player)?.team;
    if (!to || !team) return null;
    return svg(
      "g",
      {
        class: `board-ghost ${styleOf(team)}`,
        transform: `translate(${to[0]} ${to[1]})`,
        "aria-hidden": "true", // the path itself and its panel do the same for the keyboard
        "data-ghost": index,
        on: grip({ what: "element", index, point: "end" }),
      },
      svg("title", `${player} after step ${diagram!.elements[index]!.step}: draw the next action from here`),
      svg("circle.board-disc", { r: RADIUS }),
      svg("text.inside", { y: 0.11 }, player),
    );
  }

  function placeMark({ name, at: [x, z] }: PlaceShape): SVGElement {
    const chosen = selection?.what === "place" && selection.name === name;
    return svg(
      "g",
      {
        class: `board-place${chosen ? " chosen" : ""}`,
        transform: `translate(${x} ${z})`,
        tabindex: 0,
        role: "button",
        "aria-pressed": String(chosen),
        "aria-label": `Place ${name}, at ${x} ${z}`,
        "data-place": name,
        on: grip({ what: "place", name }),
      },
      svg("rect", { x: -0.2, y: -0.2, width: 0.4, height: 0.4 }),
      svg("text", { y: 0.72, "text-anchor": "middle" }, name), // a player may stand on it
    );
  }

  function bar(points: readonly Spot[]): SVGElement | null {
    const [end, before] = [points.at(-1), points.at(-8) ?? points[0]];
    if (!end || !before) return null;
    const [dx, dz] = [end[0] - before[0], end[1] - before[1]];
    const length = Math.hypot(dx, dz);
    const [ax, az] = length > 1e-9 ? [(-dz / length) * 0.42, (dx / length) * 0.42] : [0.42, 0];
    return svg("polyline.board-line.bar", {
      points: text([
        [end[0] - ax, end[1] - az],
        [end[0] + ax, end[1] + az],
      ]),
    });
  }

  function handle(index: number, point: "end" | number, at: Spot): SVGElement {
    const mine: Selection = { what: "element", index, point };
    const label = `${point === "end" ? "End" : `Point ${point + 1}`} of ${nameOf(diagram!, index)}`;
    return svg("circle.board-handle", {
      cx: at[0],
      cy: at[1],
      r: 0.16,
      tabindex: 0,
      role: "button",
      "aria-label": label,
      "data-handle": `${index}-${point}`,
      on: grip(mine),
    });
  }

  function elementMark(index: number, stroke: Stroke): SVGElement {
    const one = diagram!.elements[index]!;
    const reason = reasonOf(index);
    const team = styleOf(diagram!.players.find(({ name }) => name === one.player)?.team ?? "player");
    const middle = stroke.points[Math.floor(stroke.points.length / 2)] ?? [0, 0];
    const straight = stroke.points.length === 2;
    const at: Spot = straight
      ? [(stroke.points[0]![0] + stroke.points[1]![0]) / 2, (stroke.points[0]![1] + stroke.points[1]![1]) / 2]
      : middle;
    const mine: Selection = { what: "element", index, point: one.to ? "end" : null };
    const classes = ["board-element", team, `look-${stroke.look}`];
    if (reason) classes.push("infeasible");
    if (isSelected(index)) classes.push("chosen");
    return svg(
      "g",
      {
        class: classes.join(" "),
        tabindex: 0,
        role: "button",
        "aria-pressed": String(isSelected(index)),
        "aria-label": `${nameOf(diagram!, index)}${reason ? `: cannot be played, ${reason}` : ""}`,
        "data-element": index,
        on: {
          pointerdown: (event: PointerEvent) => event.stopPropagation(),
          click: () => actions.select(mine),
          dblclick: (event: MouseEvent) => {
            if (endsAtPlace(one.kind)) actions.bend(index, groundOf(event));
          },
          keydown: (event: KeyboardEvent) => keys(event, mine),
        },
      },
      svg("title", reason ?? nameOf(diagram!, index)),
      svg("polyline.board-hit", { points: text(stroke.points) }),
      svg("polyline.board-line", {
        points: text(stroke.points),
        ...(stroke.arrow ? { "marker-end": `url(#arrow-${reason ? "bad" : team})` } : {}),
      }),
      stroke.bar ? bar(stroke.points) : null,
      svg("circle.board-step-disc", { cx: at[0], cy: at[1], r: 0.22 }),
      svg("text.board-step", { x: at[0], y: at[1] + 0.11 }, one.step),
    );
  }

  function arrowHead(name: string): SVGElement {
    return svg(
      "marker",
      {
        id: `arrow-${name}`,
        class: `board-arrow ${name}`,
        viewBox: "0 0 10 10",
        refX: 8,
        refY: 5,
        markerWidth: 0.42,
        markerHeight: 0.42,
        markerUnits: "userSpaceOnUse",
        orient: "auto",
      },
      svg("path", { d: "M0,0.5 L10,5 L0,9.5 z" }),
    );
  }

  function ground(): SVGElement[] {
    const { ground, places } = diagram!;
    const marks: SVGElement[] = [
      svg("rect.board-ground", {
        x: ground.left,
        y: ground.back,
        width: ground.width,
        height: ground.length,
      }),
    ];
    for (const line of groundLines(ground)) {
      marks.push(svg("polyline.board-court-line", { points: text(line) }));
    }
    for (const { at, width } of places.filter((one) => one.width > 0 && !one.tall)) {
      marks.push(svg("circle.board-rim", { cx: at[0], cy: at[1], r: width / 2 }));
    }
    marks.push(...places.filter((one) => !one.given).map(placeMark));
    return marks;
  }

  function focused(): string | null {
    const held = document.activeElement;
    if (!held || !element.contains(held)) return null;
    for (const name of ["data-player", "data-place", "data-handle", "data-element"]) {
      const value = held.getAttribute(name);
      if (value !== null) return `[${name}="${CSS.escape(value)}"]`;
    }
    return null;
  }

  function draw(): void {
    if (!diagram) return;
    const { ground: field } = diagram;
    const [width, length] = [field.width + 2 * MARGIN, field.length + 2 * MARGIN];
    const kept = focused();
    const strokes = diagram.elements.map((_, i) => strokeOf(diagram!, i, board?.holder ?? null));
    const handles: SVGElement[] = [];
    if (selection?.what === "element") {
      const { index } = selection;
      const one = diagram.elements[index];
      one?.via.forEach((at, i) => handles.push(handle(index, i, at)));
      if (one?.to) handles.push(handle(index, "end", one.to));
    }
    const from = drawn && drawn.after !== null ? diagram.elements[drawn.after]?.to : null;
    const rubber = drawn ? (from ?? placeBefore(diagram, drawn.player, Infinity)) : null;
    picture ??= makePicture();
    picture.setAttribute("viewBox", `${field.left - MARGIN} ${field.back - MARGIN} ${width} ${length}`);
    picture.classList.toggle("drawing", tool !== "");
    fill(
      picture,
      svg("defs", ["first", "second", "other", "bad"].map(arrowHead)),
      ground(),
      strokes.map((stroke, i) => elementMark(i, stroke)),
      diagram.elements.map((_, i) => ghost(i)),
      diagram.players.map(playerMark),
      handles,
      rubber ? svg("polyline.board-rubber", { points: text([rubber, drawn!.to]) }) : null,
      tokens.element,
    );
    if (kept) picture.querySelector<SVGElement>(kept)?.focus({ preventScroll: true });
  }

  function makePicture(): SVGSVGElement {
    const made = svg("svg", { role: "group", "aria-label": "Ground seen from above" });
    made.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      actions.place(groundOf(event));
    });
    made.addEventListener("pointermove", (event) => {
      if (drawn) {
        drawn = { ...drawn, to: groundOf(event) };
        draw();
      } else if (dragging) {
        dragging.moved = true;
        actions.move(dragging.selection, groundOf(event), false);
      }
    });
    made.addEventListener("pointerup", (event) => {
      const [line, held] = [drawn, dragging];
      drawn = dragging = null;
      if (line)
        actions.draw(
          line.player,
          groundOf(event),
          needsOther(tool) ? playerAt(groundOf(event), line.player) : null,
          line.after,
        );
      else if (held?.moved) actions.move(held.selection, groundOf(event), true);
      else if (held) actions.select(held.selection);
    });
    made.addEventListener("pointercancel", () => {
      drawn = dragging = null;
      draw();
    });
    element.append(made);
    return made;
  }

  return {
    element,
    show(
      nextDiagram: DiagramShape,
      nextBoard: BoardReply | null,
      nextSelection: Selection,
      nextTool: string,
    ): void {
      [diagram, board, selection, tool] = [nextDiagram, nextBoard, nextSelection, nextTool];
      draw();
    },
    /** Show where the players of the scene are now; none: they are where they were drawn. */
    setTokens(next: readonly Token[]): void {
      element.classList.toggle("playing", next.length > 0);
      tokens.show(next);
    },
  };
}
