/** The actions of a generated motion as blocks: drag, stretch, take another place, pick an excerpt. */

import { named, numberField, onSubmit } from "../../dom/fields.ts";
import { get, messageOf } from "../../api/client.ts";
import type { ActionVerdict, MadeReply, ShownBlock } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { openDialog } from "../../parts/asking.ts";
import { makeMenu } from "../../parts/menu.ts";
import { interval, probability, sharedReason } from "../../parts/text.ts";
import { sayGrade } from "../search/certainty.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import { CLICK } from "../../timeline/timeline.ts";
import type { Context } from "../view.ts";

/** What a timeline asks for. */
export type Wish = Omit<ShownBlock, "places">;

const SHORTEST = 0.5;
const LONGEST = 60;
/** Answers among which an excerpt is picked. */
const OFFERED = 8;

/** The blocks of a motion as wishes; each keeps the place that it has. */
export function wishesOf(blocks: readonly ShownBlock[]): Wish[] {
  return blocks.map(({ places: _, ...wish }) => wish);
}

export function moved<T>(list: readonly T[], from: number, to: number): T[] {
  const rest = list.filter((_, i) => i !== from);
  return [...rest.slice(0, to), list[from]!, ...rest.slice(to)];
}

function verdictOf(one: ActionVerdict | undefined): { mark: string; text: string; kind: string } {
  if (!one) return { mark: "?", text: "not judged", kind: "" };
  const p = one.probability === null ? "" : ` ${probability(one.probability)}, ${sayGrade(one.probability)}`;
  if (one.shown) return { mark: "✓", text: `shown${p}`, kind: "shown" };
  return one.shown === null
    ? { mark: "?", text: `not sure${p}`, kind: "not-sure" }
    : { mark: "✕", text: `not shown${p}`, kind: "not-shown" };
}

/** Ask for an excerpt: one of the answers to a phrase, or the times of a capture. */
function pickExcerpt(context: Context, wish: Wish, picked: (part: Partial<Wish>) => void): void {
  const clips: Clip[] = [];
  const capture = h("input.field", {
    id: "pick-capture",
    required: true,
    value: wish.capture ?? "",
  });
  const number = (id: string, value: number | null): HTMLInputElement =>
    numberField(id, 0, { step: "any", required: true, value: value ?? "" });
  const [from, to] = [number("pick-from", wish.start), number("pick-to", wish.end)];
  const choose = (name: string, start: number, end: number): void => {
    dialog.close();
    picked({ capture: name, start, end, place: null });
  };
  const form = h(
    "form.row",
    named("Capture", capture),
    named("from", from),
    named("to", to),
    h("button.button", { type: "submit" }, "Use this excerpt"),
  );
  onSubmit(form, () => {
    choose(capture.value.trim(), from.valueAsNumber, to.valueAsNumber);
  });
  const list = h("ul.plain.pick-list", { "aria-label": "Places that show it" });
  const state = h("p.muted.small", { role: "status" }, "Searching…");
  const dialog = openDialog(`An excerpt for “${wish.phrase}”`, form, state, list);
  dialog.classList.add("wide");
  dialog.addEventListener("close", () => clips.forEach((clip) => clip.close()));
  get("/api/search", { q: wish.phrase, limit: OFFERED }).then(
    ({ matches, matches_anything }) => {
      state.textContent =
        matches_anything === false
          ? "Nothing shows it well; these are the nearest."
          : "Or one of these answers:";
      fill(
        list,
        matches.map((match) => {
          const label = `${match.capture}, ${interval(match.start, match.end)}`;
          const clip = makeClip(context, { ref: match.ref, part: [match.start, match.end], label });
          clips.push(clip);
          return h(
            "li",
            clip.element,
            button("link", label, () => choose(match.capture, match.start, match.end)),
          );
        }),
      );
    },
    (fault: unknown) => void (state.textContent = messageOf(fault)),
  );
}

/** The actions of a motion as blocks in the lane of its timeline, and the tools of the chosen one. */
export interface Blocks {
  readonly lane: HTMLElement;
  readonly tools: HTMLElement;
}

/** Which block is chosen; it stays chosen when the motion is made again. */
export interface Chosen {
  at: number;
  /** Whether it was moved by keys, and keeps the focus. */
  focus: boolean;
}

/**
 * The blocks of a motion: an edge is dragged to make an action longer or shorter, a block to another
 * place in the order. Every change asks for the motion of the changed timeline.
 */
export function blocksOf(
  context: Context,
  made: MadeReply,
  chosen: Chosen,
  ask: (wishes: readonly Wish[]) => void,
  seek: (time: number) => void,
): Blocks | null {
  const { blocks, shown_actions } = made;
  if (blocks.length === 0) return null;
  const wishes = wishesOf(blocks);
  const shared = sharedReason(shown_actions);
  chosen.at = Math.min(chosen.at, blocks.length - 1);
  const change = (at: number, part: Partial<Wish>): void =>
    ask(wishes.map((one, i) => (i === at ? { ...one, ...part } : one)));
  const lengthOf = (at: number): number => {
    const judged = shown_actions[at];
    return judged ? judged.end - judged.start : 1;
  };
  const lengthen = (at: number, value: number): void => {
    if (!Number.isFinite(value)) return;
    const length = Math.min(Math.max(value, SHORTEST), LONGEST);
    change(at, { seconds: Math.round(length * 10) / 10 });
  };

  const lane = h("ol.plain.made-lane", { "aria-label": "Actions on the timeline" });
  const tools = h("div.made-tools");
  const elements = blocks.map((block, at) => blockElement(block, at));
  fill(lane, elements);

  function choose(at: number): void {
    chosen.at = at;
    elements.forEach((one, i) => {
      one.classList.toggle("chosen", i === at);
      one.querySelector("button")!.setAttribute("aria-pressed", String(i === at));
    });
    showTools();
  }

  function blockElement(block: ShownBlock, at: number): HTMLElement {
    const judged = shown_actions[at];
    const { mark, text, kind } = verdictOf(judged);
    const body = h(
      "button.made-block-body",
      { type: "button", title: `${block.phrase}: ${text}` },
      h("span.mark", { "aria-hidden": "true" }, mark),
      h("b", block.phrase),
      " ",
      h("span.made-block-text", text),
    );
    body.addEventListener("keydown", (event) => {
      const to = at + (event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0);
      if (to === at || !event.altKey) return;
      event.preventDefault(); // else the browser goes back
      if (!wishes[to]) return;
      Object.assign(chosen, { at: to, focus: true });
      ask(moved(wishes, at, to));
    });
    body.addEventListener("click", () => {
      choose(at);
      if (judged) seek(judged.start);
    });
    const edge = h("span.made-block-edge", { title: `Drag: how long ${block.phrase} lasts` });
    const start = judged?.start ?? 0;
    const element = h(
      "li",
      {
        class: `made-block ${kind}`,
        style: {
          left: `${(100 * start) / made.seconds}%`,
          width: `${(100 * lengthOf(at)) / made.seconds}%`,
        },
      },
      body,
      edge,
    );
    drag(element, edge, at);
    return element;
  }

  /** Let a block be dragged: what lies behind an edge follows it, what a block passes makes room. */
  function drag(element: HTMLElement, edge: HTMLElement, at: number): void {
    let from = { x: 0, edge: false, pointer: -1 };
    let size = 0;
    let going = false;
    const shift = (i: number, pixels: number): void => {
      elements[i]!.style.transform = pixels ? `translateX(${pixels}px)` : "";
    };
    const middle = (i: number): number => elements[i]!.offsetLeft + elements[i]!.offsetWidth / 2;
    const placeAt = (by: number): number =>
      elements.filter((_, i) => i !== at && middle(i) < middle(at) + by).length;
    const lengthAt = (by: number): number =>
      Math.min(Math.max(lengthOf(at) + (by * made.seconds) / lane.clientWidth, SHORTEST), LONGEST);
    const still = (): void => {
      going = false;
      element.classList.remove("dragged");
      element.style.width = `${(100 * lengthOf(at)) / made.seconds}%`;
      element.removeAttribute("data-seconds");
      elements.forEach((_, i) => shift(i, 0));
    };
    element.addEventListener("pointerdown", (event) => {
      event.stopPropagation(); // the timeline would move its cursor
      if (event.button !== 0) return;
      from = { x: event.clientX, edge: event.target === edge, pointer: event.pointerId };
      size = element.offsetWidth;
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", (event) => {
      if (event.pointerId !== from.pointer) return;
      const by = event.clientX - from.x;
      going ||= Math.abs(by) > CLICK;
      if (!going) return;
      element.classList.add("dragged");
      if (from.edge) {
        const length = lengthAt(by);
        const wide = (length * lane.clientWidth) / made.seconds;
        element.style.width = `${wide}px`;
        element.dataset["seconds"] = `${length.toFixed(1)} s`;
        elements.forEach((_, i) => i > at && shift(i, wide - size));
        return;
      }
      const to = placeAt(by);
      elements.forEach((_, i) =>
        shift(i, i === at ? by : i > at && i <= to ? -size : i < at && i >= to ? size : 0),
      );
    });
    element.addEventListener("pointerup", (event) => {
      if (event.pointerId !== from.pointer) return; // pressed elsewhere, or by another button
      from.pointer = -1;
      if (!going) {
        if (from.edge) return;
        element.querySelector("button")!.click(); // the capture keeps the click from the button
        return;
      }
      const by = event.clientX - from.x;
      const to = placeAt(by);
      const length = lengthAt(by);
      chosen.at = from.edge ? at : to;
      still();
      if (from.edge) lengthen(at, length);
      else if (to !== at) ask(moved(wishes, at, to));
      else choose(at);
    });
    element.addEventListener("pointercancel", () => {
      from.pointer = -1;
      still();
    });
  }

  function showTools(): void {
    const { at } = chosen;
    const block = blocks[at]!;
    const judged = shown_actions[at];
    const { mark, text, kind } = verdictOf(judged);
    const now = block.seconds ?? Math.round(lengthOf(at) * 10) / 10;
    const another = ((block.place ?? -1) + 1) % Math.max(block.places, 1);
    const where = block.capture
      ? `picked: ${block.capture}, ${interval(block.start!, block.end!)}`
      : block.place === null
        ? (judged?.done[0] ?? "")
        : `${judged?.done[0] ?? ""} · place ${block.place + 1} of ${block.places}`;
    const seconds = h("input.number", {
      type: "number",
      min: SHORTEST,
      max: LONGEST,
      step: "any",
      value: now.toFixed(1),
      "aria-label": `Seconds of ${block.phrase}`,
      on: { change: () => lengthen(at, seconds.valueAsNumber) },
    });
    const tool = (text: string, label: string, disabled: boolean, run: () => void): HTMLElement =>
      button("plain", text, run, { "aria-label": `${label} ${block.phrase}`, title: label, disabled });
    const move = (to: number): void => {
      chosen.at = to;
      ask(moved(wishes, at, to));
    };
    fill(
      tools,
      h(
        "p",
        { class: kind },
        h("span.mark", { "aria-hidden": "true" }, mark),
        " ",
        h("b", block.phrase),
        ` ${text}`,
        judged?.reason && !judged.shown && judged.reason !== shared ? `: ${judged.reason}` : "",
        h("span.muted", where ? ` · ${where}` : ""),
      ),
      h(
        "div.row",
        h("label.check", seconds, "s"),
        tool("Another place", "Another place for", block.places < 2 && !block.capture, () =>
          change(at, { place: another, capture: null, start: null, end: null }),
        ),
        tool("Pick…", "Pick an excerpt for", false, () =>
          pickExcerpt(context, wishes[at]!, (part) => change(at, part)),
        ),
        makeMenu("More", [
          tool("Move earlier", "Move earlier:", at === 0, () => move(at - 1)),
          tool("Move later", "Move later:", at === blocks.length - 1, () => move(at + 1)),
          tool("Leave out", "Leave out", blocks.length === 1, () => ask(wishes.filter((_, i) => i !== at))),
        ]),
        adding,
      ),
      shared ? h("p.muted.small", `Not sure: ${shared}.`) : null,
    );
  }

  const phrase = h("input.field", { placeholder: "and then…", "aria-label": "A further action" });
  const adding = h(
    "form.row",
    phrase,
    h("button.button.plain", { type: "submit" }, icon("plus"), "Add"),
    button("plain", "Add by hand…", () => pickFurther(), {
      title: "Add it as an excerpt that you pick: no caption needs to say it",
    }),
  );
  /** The typed action; null: nothing is typed. */
  function further(): Wish | null {
    const text = phrase.value.trim();
    if (!text) phrase.focus();
    return text ? { phrase: text, seconds: null, place: null, capture: null, start: null, end: null } : null;
  }
  function pickFurther(): void {
    const fresh = further();
    if (fresh) pickExcerpt(context, fresh, (part) => ask([...wishes, { ...fresh, ...part }]));
  }
  onSubmit(adding, () => {
    const fresh = further();
    if (fresh) ask([...wishes, fresh]);
  });
  choose(chosen.at);
  if (chosen.focus) requestAnimationFrame(() => elements[chosen.at]?.querySelector("button")?.focus());
  chosen.focus = false;
  return { lane, tools };
}
