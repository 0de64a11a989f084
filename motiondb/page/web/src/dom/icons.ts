/** Small line icons, drawn here. */

import { svg } from "./element.ts";

const PATHS = {
  play: "M5 3.5v9l7.5-4.5z",
  pause: "M4.5 3.5v9M11.5 3.5v9",
  back: "M11 3.5v9L5 8zM4 3.5v9",
  forward: "M5 3.5v9L11 8zM12 3.5v9",
  loop: "M3 8a4 4 0 0 1 4-4h5m-2-2 2 2-2 2M13 8a4 4 0 0 1-4 4H4m2 2-2-2 2-2",
  follow: "M8 5.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5M8 1.5v3M8 11.5v3M1.5 8h3M11.5 8h3",
  grid: "M2 5.5h12M2 10.5h12M5.5 2v12M10.5 2v12",
  trails: "M2 12c3 0 3-8 6-8s3 6 6 4",
  contact: "M2 13.5h12M8 2v7M5 6.5 8 9.5l3-3",
  turntable: "M2 9.5a6 3 0 1 0 6-3M8 6.500 10 4.500M8 6.500 10 8.500",
  camera: "M3 8a5 5 0 1 1 1.6 3.7M3 12.5V9.5h3",
  full: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  close: "M3.5 3.5l9 9M12.5 3.5l-9 9",
  search: "M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9M10.5 10.5l3.5 3.5",
  file: "M4 1.5h5l3 3v10H4zM9 1.5v3h3",
  download: "M8 2v8M4.5 7 8 10.5 11.5 7M2.5 13.5h11",
  undo: "M5.5 3 2.5 6l3 3M2.5 6H10a3.5 3.5 0 0 1 0 7H6",
  redo: "M10.5 3l3 3-3 3M13.5 6H6a3.5 3.5 0 0 0 0 7h4",
  more: "M2.5 3.5h11M2.5 8h11M2.5 12.5h7",
  like: "M2 8a6 4 0 1 0 12 0A6 4 0 1 0 2 8M8 8h.01",
  help: "M6 6a2 2 0 1 1 2.8 1.9C8.2 8.300 8 8.800 8 9.500M8 12.500v.01",
  list: "M5.5 3.5H14M5.5 8H14M5.5 12.5H14M2 3.5h.01M2 8h.01M2 12.5h.01",
  plus: "M8 3v10M3 8h10",
} as const;

export type IconName = keyof typeof PATHS;

/** An icon of 16 pixels in the colour of the text around it, hidden from screen readers. */
export function icon(name: IconName): SVGElement {
  return svg(
    "svg.icon",
    { viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true", focusable: "false" },
    svg("path", { d: PATHS[name] }),
  );
}
