/** Save files that the server makes. */

import { postForFile } from "../api/client.ts";
import type { Part } from "../api/types.ts";
import { button } from "../dom/button.ts";
import { icon } from "../dom/icons.ts";
import { makeMenu } from "./menu.ts";

/** The formats of downloads, as they are called on the page; the first two stand outside the menu. */
const NAMES = {
  bvh: "BVH",
  glb: "glTF",
  fbx: "FBX",
  usd: "USD",
  npz: "npz",
  csv: "CSV",
  parquet: "Parquet",
  source: "original files",
} as const;
const OUTSIDE = 2;

export type FileFormat = keyof typeof NAMES;

/** Hand a file to the browser's downloads. */
export function saveBlob(name: string, blob: Blob): void {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/**
 * Download parts as one file, or as a zip of several with the origin of generated motions.
 * `alone`: without the origin, which glTF holds itself.
 */
export async function download(
  items: readonly Part[],
  format: FileFormat,
  alone = items.length === 1 && format === "glb",
): Promise<void> {
  const { name, blob } = await postForFile("/api/download", { items, format, canonical: false, alone });
  saveBlob(name, blob);
}

/** One menu of all formats in which a part of a capture can be written. */
export function downloadMenu(
  label: string,
  writes: readonly string[],
  save: (format: FileFormat) => void,
): HTMLElement {
  const formats = (Object.keys(NAMES) as FileFormat[]).filter((format) => writes.includes(format));
  return makeMenu(
    label,
    formats.map((format) => downloadButton(format, save)),
  );
}

/** A button that saves one format. */
export function downloadButton(format: FileFormat, save: (format: FileFormat) => void): HTMLElement {
  return button("plain", [icon("download"), NAMES[format]], () => save(format), {
    "aria-label": `Download as ${NAMES[format]}`,
  });
}

/**
 * Buttons for the usual formats, and a menu of the others that this server writes.
 * `source`: also the files as they were added, of which no part can be taken.
 */
export function downloadButtons(
  writes: readonly string[],
  save: (format: FileFormat) => void,
  source: boolean,
): HTMLElement[] {
  const offered = (Object.keys(NAMES) as FileFormat[]).filter((format) =>
    format === "source" ? source : writes.includes(format),
  );
  const buttons = offered.map((format) => downloadButton(format, save));
  return [...buttons.slice(0, OUTSIDE), makeMenu("Other formats", buttons.slice(OUTSIDE))];
}
