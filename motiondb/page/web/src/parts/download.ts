/** Save files that the server makes. */

import { postForFile } from "../api/client.ts";
import type { Part } from "../api/types.ts";

export type FileFormat = "bvh" | "glb" | "npz" | "source";

/** Hand a file to the browser's downloads. */
export function saveBlob(name: string, blob: Blob): void {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Download parts as one file, or as a zip of several. */
export async function download(items: readonly Part[], format: FileFormat): Promise<void> {
  const { name, blob } = await postForFile("/api/download", { items, format, canonical: false });
  saveBlob(name, blob);
}
