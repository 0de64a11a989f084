/** The report of a scene in sentences: impossible motions first, then every rule, with its moment. */

import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import { plural } from "../../parts/text.ts";
import type { DiagramShape, MeasuredRule, SceneReply } from "../../api/types.ts";

/** Frames a second of scenes. */
export const FPS = 30;

/** Places that are nearer than this are the same, metres: the report rounds them. */
const SAME = 0.006;

/** Broken rules come first, then by the frame. */
export function inOrder(rules: readonly MeasuredRule[]): MeasuredRule[] {
  return [...rules].sort((a, b) => Number(a.kept) - Number(b.kept) || (a.frame ?? 0) - (b.frame ?? 0));
}

const IMPOSSIBLE: Record<string, string> = {
  airborne: "both feet in the air for too long",
  speed: "too fast",
  step: "steps too long",
  "foot jump": "a planted foot jumps",
  limbs: "limbs pass through one another",
};

const UNITS: Record<string, string> = { deg: "°", frames: " frames" };

const action = (kind: string): string => kind.replaceAll("_", " ");

/** A target of a rule as the board names it: a player, or a place such as "(0.4, 8.2)". */
export function targetName(about: string, board: DiagramShape, player = ""): string {
  const place = /^\((-?[\d.]+), (-?[\d.]+)\)$/.exec(about);
  if (!place) return about;
  const [x, z] = [Number(place[1]), Number(place[2])];
  const here = (at: readonly number[] | null | undefined): boolean =>
    !!at && Math.hypot(at[0]! - x, at[1]! - z) < SAME;
  const named = board.places.find((one) => here(one.at));
  if (named) return `the ${named.name}`;
  const whose = (name: string): string => (name === player ? "its" : `${name}'s`);
  const start = board.players.find((one) => here(one.at) && (!player || one.name === player));
  if (start) return `the place where ${start.name} starts`;
  // The player's own actions come first: two paths may end at one place.
  const elements = [...board.elements].sort(
    (a, b) => Number(b.player === player) - Number(a.player === player),
  );
  for (const one of elements) {
    const path = `${whose(one.player)} ${action(one.kind)} in step ${one.step}`;
    if (here(one.to)) return `the end of ${path}`;
    if (one.via.some(here)) return `the bend of ${path}`;
  }
  return `the place ${x} m to the right, ${z} m down the board`;
}

/** What a rule asks for, as the rest of a sentence that begins with the player and the action. */
export function ruleSentence(rule: MeasuredRule, board: DiagramShape): string {
  const { about, player } = rule;
  if (about === "nobody") return "nobody can take part in it";
  if (rule.rule === "position") return `at ${targetName(about, board, player)}`;
  if (rule.rule === "direction") {
    const heading = /^(-?\d+) deg$/.exec(about);
    return heading ? `faces ${heading[1]}° from the board's top` : `faces ${targetName(about, board)}`;
  }
  if (rule.rule === "distance") {
    const parts = /^(.*), (\S+) to (\S+) m$/.exec(about);
    if (!parts) return `distance to ${about}`;
    const [, target, near, far] = parts;
    const range =
      far === "inf" ? `at least ${near} m` : near === "0" ? `at most ${far} m` : `${near} to ${far} m`;
    return `${range} from ${targetName(target!, board)}`;
  }
  if (rule.rule === "line") {
    const ends = about.split(" - ").map((one) => targetName(one, board));
    return `on the line from ${ends.join(" to ")}`;
  }
  if (rule.rule === "synchronisation") {
    const [partner, actions = ""] = about.split(" ", 2);
    return `in time with ${partner}'s ${actions.split("|").map(action).join(" or ")}`;
  }
  return `${rule.rule} ${about}`;
}

/** Rules that ask for the same at the same moment, with less and more room, stand in one row. */
export function together(rules: readonly MeasuredRule[]): MeasuredRule[][] {
  const rows = new Map<string, MeasuredRule[]>();
  for (const rule of inOrder(rules)) {
    const { player, action: kind, clip, about, frame, after, kept } = rule;
    const key = JSON.stringify([player, kind, clip, rule.rule, about, frame, after, kept]);
    rows.set(key, [...(rows.get(key) ?? []), rule]);
  }
  return [...rows.values()];
}

/** What was measured, and what is allowed by each of some rules that ask for the same. */
function value(rules: readonly MeasuredRule[]): string {
  const { unit: short, after, about } = rules[0]!;
  if (about === "nobody") return "";
  const unit = UNITS[short] ?? ` ${short}`;
  const digits = short === "m" ? 2 : 1;
  const text = (one: number | null): string => (one === null ? "not measured" : one.toFixed(digits));
  const allowed = rules.map((one) => text(one.threshold));
  // A distance has its bounds in its sentence: beyond them nothing is allowed.
  const room = rules.some((one) => one.threshold !== 0)
    ? `, ${[...new Set(allowed)].join(" and ")} allowed`
    : "";
  return `${text(after)}${unit}${room}`;
}

function frameButton(frame: number, jump: (time: number) => void): HTMLElement {
  return button("time", `${(frame / FPS).toFixed(2)} s`, () => jump(frame / FPS), {
    "aria-label": `Show ${(frame / FPS).toFixed(2)} s, frame ${frame}`,
  });
}

function rowOf(
  rules: readonly MeasuredRule[],
  board: DiagramShape,
  jump: (time: number) => void,
): HTMLElement {
  const rule = rules[0]!;
  const { frame } = rule;
  return h(
    "tr",
    { class: rule.kept ? "kept" : "broken" },
    h(
      "td",
      h("span.mark", { "aria-hidden": "true" }, rule.kept ? "✓" : "✕"),
      h("span.visually-hidden", rule.kept ? "kept" : "broken"),
    ),
    h("td", h("b", rule.player), ` ${action(rule.action)}: `, ruleSentence(rule, board)),
    h("td.time", value(rules)),
    h("td", frame === null ? "" : frameButton(frame, jump)),
  );
}

function impossibleList({ report }: SceneReply, jump: (time: number) => void): HTMLElement | null {
  const impossible = report.impossible ?? [];
  if (impossible.length === 0) return null;
  return h(
    "section.board-impossible",
    { "aria-label": "Impossible motions" },
    h("h3", `${plural(impossible.length, "motion")} that nobody can make`),
    h(
      "ul.plain",
      impossible.map((one) =>
        h(
          "li",
          h("b", one.players.join(" and ")),
          ` ${action(one.action)}: ${IMPOSSIBLE[one.kind] ?? one.kind}, `,
          frameButton(one.frame, jump),
        ),
      ),
    ),
  );
}

const SEEN: Record<string, string> = {
  guard: "is too far from whom it guards",
  stands: "stands for most of the scene",
  "held pose": "holds a pose without moving",
  misses: "misses the target",
  object: "is in the way of the object",
  reach: "reaches for the object in vain",
  order: "comes after a later step",
  place: "passes through a thing on the ground",
  limbs: "has limbs that touch somebody",
  leap: "changes the pose at once",
};

/** What a viewer sees at once although no rule is about it. */
function seenList({ report }: SceneReply, jump: (time: number) => void): HTMLElement | null {
  const seen = report.seen ?? [];
  if (seen.length === 0) return null;
  return h(
    "ul.plain",
    { "aria-label": "Seen at once" },
    seen.map((one) =>
      h("li", h("b", one.players[0]!), ` ${SEEN[one.kind] ?? one.kind}, `, frameButton(one.start, jump)),
    ),
  );
}

/** The report beside the player; `jump` shows a time of the scene. */
export function sceneReport(scene: SceneReply, jump: (time: number) => void): HTMLElement {
  const { report, board } = scene;
  const rules = report.by_rule;
  const broken = rules.filter((one) => !one.kept).length;
  const verdict = broken
    ? `${plural(broken, "rule")} of ${rules.length} broken`
    : `${rules.length === 1 ? "The rule is" : `All ${rules.length} rules are`} kept`;
  return h(
    "section.board-report",
    { "aria-label": "Report of the scene", tabindex: 0 },
    impossibleList(scene, jump),
    seenList(scene, jump),
    h(
      "details.why",
      { open: true },
      h("summary", { class: broken ? "broken" : "" }, verdict),
      h(
        "table.board-rules",
        h(
          "thead",
          h(
            "tr",
            h("th", { scope: "col" }, h("span.visually-hidden", "kept")),
            h("th", { scope: "col" }, "what was asked"),
            h("th", { scope: "col" }, "off by"),
            h("th", { scope: "col" }, "moment"),
          ),
        ),
        h(
          "tbody",
          together(rules).map((row) => rowOf(row, board, jump)),
        ),
      ),
    ),
  );
}
