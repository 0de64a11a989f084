/** Things that are shown in one view and in the next one move from where they were. */

import { REDUCED } from "./wishes.ts";

let places = new Map<string, DOMRect>();

/** Remember where things stand, before their view is closed. */
export function rememberPlaces(things: ReadonlyMap<string, HTMLElement>): void {
  places = new Map([...things].map(([name, element]) => [name, element.getBoundingClientRect()]));
}

/** Let things of the next view come from where the same ones stood; the others appear. */
export function land(things: readonly (readonly [string, HTMLElement])[]): void {
  const from = places;
  places = new Map();
  if (REDUCED.matches || from.size === 0) return;
  for (const [name, element] of things) {
    const [before, now] = [from.get(name), element.getBoundingClientRect()];
    const start = before
      ? `translate(${before.x - now.x}px, ${before.y - now.y}px) scale(${before.width / now.width}, ${before.height / now.height})`
      : "scale(0.96)";
    element.animate(
      [
        { transformOrigin: "0 0", transform: start, opacity: before ? 1 : 0 },
        { transformOrigin: "0 0", transform: "none", opacity: 1 },
      ],
      { duration: before ? 420 : 260, easing: "cubic-bezier(0.2, 0.8, 0.3, 1)" },
    );
  }
}
