/** Search with a file: it is uploaded, not added to the database. */

import type { NamedFile } from "../../parts/dropping.ts";
import { sortFiles, upload } from "../../parts/upload.ts";
import { go, routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";

export async function searchByFile(context: Context, files: readonly NamedFile[]): Promise<void> {
  if (files.length === 0) return;
  const { send, refused } = sortFiles(files, context.status().accepts);
  if (send.length === 0) {
    throw new Error(`${refused[0]?.name ?? "The file"}: ${refused[0]?.message ?? "cannot be read"}.`);
  }
  context.notify(`Reading ${send[0]!.path}…`);
  const sent = await upload(send);
  const capture = sent.files.find((one) => one.kind === "capture");
  if (!capture) throw new Error("None of these files is a capture.");
  go(routeTo("search", { like: capture.ref }));
}
