/** The example of a search: a capture or an uploaded file, with the part that is searched for. */

import { ApiError, get, isAbort } from "../../api/client.ts";
import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { makeTake } from "../../take/take.ts";
import { captionLane, symbolLane, wordLane, type Lane } from "../../timeline/lanes.ts";
import type { Interval } from "../../timeline/timeline.ts";
import type { Context } from "../view.ts";

/** The name of the played motion, shown to the user. */
export function nameOf(ref: string): string {
  const name = ref.slice(ref.indexOf(":") + 1);
  return ref.startsWith("upload:") ? name.slice(name.indexOf("/") + 1) : name;
}

async function lanesOf(ref: string): Promise<Lane[]> {
  if (ref.startsWith("capture:")) {
    const facts = await get("/api/capture", { name: nameOf(ref) });
    return [captionLane(facts.words, facts.duration), symbolLane(facts.segments), wordLane(facts.recognised)];
  }
  const described = await get("/api/describe", { ref });
  const symbols = described.words.flatMap(({ start, end, symbols: list }) =>
    list.length === 1 ? [{ start, end, symbol: list[0]!, log_likelihood: null, known: true }] : [],
  );
  return [symbolLane(symbols), wordLane(described.words)];
}

export function makeExample(context: Context, selected: (part: Interval | null) => void, leave: () => void) {
  const title = h("h2");
  const take = makeTake(context, { label: "Example", onSelect: (part) => ready && selected(part) });
  let ready = false;
  let shown = "";
  const element = h(
    "section.example",
    { "aria-label": "Example" },
    h(
      "div.details-head",
      title,
      button("tool", icon("close"), leave, { "aria-label": "Remove the example" }),
    ),
    take.element,
  );
  return {
    element,
    /** Show an example; a part that is selected by the user calls `selected`. */
    async show(ref: string, part: Interval | null): Promise<void> {
      title.textContent = `Like ${nameOf(ref)}`;
      if (shown === ref) return;
      shown = ref;
      ready = false;
      try {
        const described = lanesOf(ref);
        described.catch(() => undefined); // told below, once the motion is there
        await take.load({ ref, selection: part });
        ready = true;
        take.setLanes(await described);
      } catch (fault) {
        const missing = fault instanceof ApiError && fault.status === 404; // the player says it
        if (!isAbort(fault) && !missing) context.fail(fault);
      }
      ready = true;
    },
    get part() {
      return take.selection;
    },
    close: () => take.close(),
  };
}

export type Example = ReturnType<typeof makeExample>;
