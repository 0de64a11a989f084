/** How far a wheel was turned. */

/** Pixels that a line and a page of a wheel are. */
const LINE = 16;
export const PAGE = 400;

/** How far a wheel was turned, pixels: browsers count pixels, lines or pages. */
export function pixelsOf({ deltaY, deltaMode }: Pick<WheelEvent, "deltaY" | "deltaMode">): number {
  return deltaY * ([1, LINE, PAGE][deltaMode] ?? 1);
}
