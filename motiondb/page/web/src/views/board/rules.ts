/** The report of a scene: every rule, kept or broken, with the frame to look at. */

import { h } from "../../dom/element.ts";
import { plural } from "../../parts/text.ts";
import type { MeasuredRule, SceneReply } from "../../api/types.ts";

/** Frames a second of scenes. */
export const FPS = 30;

const number = (value: number | null, unit: string): string =>
  value === null ? "" : `${Math.abs(value) >= 100 ? value.toFixed(0) : value.toFixed(2)} ${unit}`.trim();

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

function frameButton(frame: number, jump: (time: number) => void): HTMLElement {
  return h(
    "button",
    {
      class: "link time",
      type: "button",
      "aria-label": `Show frame ${frame}`,
      on: { click: () => jump(frame / FPS) },
    },
    `frame ${frame}`,
  );
}

function row(rule: MeasuredRule, jump: (time: number) => void): HTMLElement {
  const { frame } = rule;
  return h(
    "tr",
    { class: rule.kept ? "kept" : "broken" },
    h(
      "td",
      {},
      h("span", { class: "mark", "aria-hidden": "true" }, rule.kept ? "✓" : "✕"),
      rule.kept ? " kept" : " broken",
    ),
    h("td", {}, rule.player),
    h("td", {}, rule.action),
    h("td", {}, `${rule.rule}${rule.about ? `(${rule.about})` : ""}`),
    h("td", { class: "time" }, number(rule.after, rule.unit)),
    h("td", { class: "time" }, number(rule.threshold, rule.unit)),
    h("td", {}, frame === null ? "" : frameButton(frame, jump)),
  );
}

/** The table of rules; `jump` shows a time of the scene. */
export function ruleReport({ report }: SceneReply, jump: (time: number) => void): HTMLElement {
  const rules = report.by_rule;
  const broken = rules.filter((one) => !one.kept).length;
  const impossible = report.impossible ?? [];
  return h(
    "details",
    { class: "why", open: broken > 0 || impossible.length > 0 },
    h(
      "summary",
      {},
      `${plural(rules.length - broken, "rule")} of ${rules.length} kept`,
      impossible.length ? `, ${plural(impossible.length, "impossible motion")}` : "",
    ),
    impossible.length
      ? h(
          "ul",
          { class: "plain board-impossible" },
          impossible.map((one) =>
            h(
              "li",
              {},
              `${one.players.join(" and ")} ${one.action}: ${IMPOSSIBLE[one.kind] ?? one.kind}, `,
              frameButton(one.frame, jump),
            ),
          ),
        )
      : null,
    h(
      "div",
      { class: "board-rules" },
      h(
        "table",
        {},
        h(
          "thead",
          {},
          h(
            "tr",
            {},
            ["", "player", "action", "rule", "value", "allowed", "frame"].map((title) =>
              h("th", { scope: "col" }, title),
            ),
          ),
        ),
        h(
          "tbody",
          {},
          inOrder(rules).map((rule) => row(rule, jump)),
        ),
      ),
    ),
  );
}
