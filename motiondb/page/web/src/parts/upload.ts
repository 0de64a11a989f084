/** Send files to the server, after checking which of them it accepts. */

import { postForm } from "../api/client.ts";
import type { Status, UploadReply } from "../api/types.ts";
import type { NamedFile } from "./dropping.ts";
import { bytesText, plural } from "./text.ts";

export interface Sorted {
  send: NamedFile[];
  /** Files that the server would refuse, with the reason. */
  refused: { name: string; message: string }[];
}

/** Sort files by whether the server accepts them. */
export function sortFiles(files: readonly NamedFile[], accepts: Status["accepts"]): Sorted {
  const endings = [...accepts.captures, ...accepts.skeletons, ...accepts.sheets];
  const sorted: Sorted = { send: [], refused: [] };
  for (const one of files) {
    const name = one.path.toLowerCase();
    if (!endings.some((ending) => name.endsWith(ending))) {
      sorted.refused.push({ name: one.path, message: `not one of ${endings.join(" ")}` });
    } else if (one.file.size > accepts.max_file_bytes) {
      sorted.refused.push({ name: one.path, message: `larger than ${bytesText(accepts.max_file_bytes)}` });
    } else if (sorted.send.length >= accepts.max_files) {
      sorted.refused.push({
        name: one.path,
        message: `more than ${plural(accepts.max_files, "file")} at once`,
      });
    } else sorted.send.push(one);
  }
  return sorted;
}

/** Upload files. Throws an `ApiError` where all are refused. */
export function upload(files: readonly NamedFile[]): Promise<UploadReply> {
  const form = new FormData();
  for (const { path, file } of files) form.append("files", file, path);
  return postForm("/api/uploads", form);
}
