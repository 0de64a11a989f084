/** What the system of the user asks of every page. */

export const DARK = matchMedia("(prefers-color-scheme: dark)");
export const REDUCED = matchMedia("(prefers-reduced-motion: reduce)");
