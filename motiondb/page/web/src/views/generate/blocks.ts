/** The actions of a generated motion as blocks: reorder, lengthen, take another place, pick an excerpt. */

import { get, messageOf } from "../../api/client.ts";
import type { ActionVerdict, MadeReply, SearchReply, ShownBlock } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { openDialog } from "../../parts/asking.ts";
import { interval, probability, sharedReason } from "../../parts/text.ts";
import { sayGrade } from "../search/certainty.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import type { Context } from "../view.ts";

/** What a timeline asks for. */
export type Wish = Omit<ShownBlock, "places">;

/** Seconds that a click makes an action longer or shorter by. */
const STEP = 1;
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
  const capture = h("input", {
    class: "field",
    id: "pick-capture",
    required: true,
    value: wish.capture ?? "",
  });
  const number = (id: string, value: number | null): HTMLInputElement =>
    h("input", {
      class: "number",
      id,
      type: "number",
      min: 0,
      step: "any",
      required: true,
      value: value ?? "",
    });
  const [from, to] = [number("pick-from", wish.start), number("pick-to", wish.end)];
  const choose = (name: string, start: number, end: number): void => {
    dialog.close();
    picked({ capture: name, start, end, place: null });
  };
  const form = h(
    "form",
    { class: "row" },
    h("label", { for: "pick-capture" }, "Capture"),
    capture,
    h("label", { for: "pick-from" }, "from"),
    from,
    h("label", { for: "pick-to" }, "to"),
    to,
    h("button", { class: "button", type: "submit" }, "Use this excerpt"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    choose(capture.value.trim(), from.valueAsNumber, to.valueAsNumber);
  });
  const list = h("ul", { class: "plain pick-list", "aria-label": "Places that show it" });
  const state = h("p", { class: "muted small", role: "status" }, "Searching…");
  const dialog = openDialog(`An excerpt for “${wish.phrase}”`, form, state, list);
  dialog.classList.add("wide");
  dialog.addEventListener("close", () => clips.forEach((clip) => clip.close()));
  get<SearchReply>("/api/search", { q: wish.phrase, limit: OFFERED }).then(
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
            {},
            clip.element,
            button("link", label, () => choose(match.capture, match.start, match.end)),
          );
        }),
      );
    },
    (fault: unknown) => void (state.textContent = messageOf(fault)),
  );
}

/** The blocks of a motion; every change asks for the motion of the changed timeline. */
export function blocksOf(
  context: Context,
  made: MadeReply,
  ask: (wishes: readonly Wish[]) => void,
  seek: (time: number) => void,
): HTMLElement | null {
  const { blocks, shown_actions } = made;
  if (blocks.length === 0) return null;
  const wishes = wishesOf(blocks);
  const shared = sharedReason(shown_actions);
  const change = (at: number, part: Partial<Wish>): void =>
    ask(wishes.map((one, i) => (i === at ? { ...one, ...part } : one)));

  function tool(label: string, text: string, run: () => void, disabled = false): HTMLElement {
    const small = { class: "button plain", type: "button", "aria-label": label, title: label, disabled };
    return h("button", { ...small, on: { click: run } }, text);
  }

  function blockElement(block: ShownBlock, at: number): HTMLElement {
    const judged = shown_actions[at];
    const { mark, text, kind } = verdictOf(judged);
    const length = judged ? judged.end - judged.start : 1;
    const seconds = h("input", {
      class: "number",
      type: "number",
      min: SHORTEST,
      max: LONGEST,
      step: "any",
      value: (block.seconds ?? length).toFixed(1),
      "aria-label": `Seconds of ${block.phrase}`,
      on: { change: () => lengthen(seconds.valueAsNumber) },
    });
    const lengthen = (value: number): void => {
      if (Number.isFinite(value)) change(at, { seconds: Math.min(Math.max(value, SHORTEST), LONGEST) });
    };
    const now = block.seconds ?? Math.round(length * 10) / 10;
    const another = ((block.place ?? -1) + 1) % Math.max(block.places, 1);
    const where = block.capture
      ? `picked: ${block.capture}, ${interval(block.start!, block.end!)}`
      : block.place === null
        ? (judged?.done[0] ?? "")
        : `${judged?.done[0] ?? ""} · place ${block.place + 1} of ${block.places}`;
    return h(
      "li",
      {
        class: `made-block ${kind}`,
        draggable: "true",
        "data-block": at,
        style: { "flex-grow": String(Math.max(length, 0.5)) },
        on: {
          dragstart: (event: DragEvent) => event.dataTransfer?.setData("text/plain", String(at)),
          dragover: (event: DragEvent) => event.preventDefault(),
          drop: (event: DragEvent) => {
            event.preventDefault();
            const from = Number(event.dataTransfer?.getData("text/plain"));
            if (from !== at && wishes[from]) ask(moved(wishes, from, at));
          },
        },
      },
      h(
        "p",
        { class: "made-block-head" },
        h("span", { class: "mark", "aria-hidden": "true" }, mark),
        button("link", block.phrase, () => judged && seek(judged.start)),
        h("span", { class: "small" }, ` ${text}`),
      ),
      judged?.reason && !judged.shown && judged.reason !== shared
        ? h("p", { class: "small" }, judged.reason)
        : null,
      h("p", { class: "muted small" }, where),
      h(
        "div",
        { class: "row" },
        tool(`Move ${block.phrase} earlier`, "←", () => ask(moved(wishes, at, at - 1)), at === 0),
        tool(
          `Move ${block.phrase} later`,
          "→",
          () => ask(moved(wishes, at, at + 1)),
          at === blocks.length - 1,
        ),
        tool(`Shorten ${block.phrase}`, "−", () => lengthen(now - STEP), now <= STEP),
        seconds,
        tool(`Lengthen ${block.phrase}`, "+", () => lengthen(now + STEP)),
        tool(
          `Another place for ${block.phrase}`,
          "Another place",
          () => change(at, { place: another, capture: null, start: null, end: null }),
          block.places < 2 && !block.capture,
        ),
        tool(`Pick an excerpt for ${block.phrase}`, "Pick…", () =>
          pickExcerpt(context, wishes[at]!, (part) => change(at, part)),
        ),
        button("tool", icon("close"), () => ask(wishes.filter((_, i) => i !== at)), {
          "aria-label": `Leave ${block.phrase} out`,
          disabled: blocks.length === 1,
        }),
      ),
    );
  }

  const phrase = h("input", { class: "field", placeholder: "and then…", "aria-label": "A further action" });
  const adding = h(
    "form",
    { class: "row" },
    phrase,
    h("button", { class: "button plain", type: "submit" }, icon("plus"), "Add"),
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
  adding.addEventListener("submit", (event) => {
    event.preventDefault();
    const fresh = further();
    if (fresh) ask([...wishes, fresh]);
  });
  return h(
    "div",
    { class: "made-blocks" },
    h("ol", { class: "plain", "aria-label": "Actions on the timeline" }, blocks.map(blockElement)),
    shared ? h("p", { class: "muted small" }, `Not sure: ${shared}.`) : null,
    adding,
  );
}
