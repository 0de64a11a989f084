/** The entry: a page of a server, or a file that carries its data. */

import { startEmbedded } from "./embedded/embedded.ts";
import { startPage } from "./shell/page.ts";

function start(): void {
  const root = document.getElementById("app")!;
  const data = document.getElementById("motiondb-data");
  if (data) startEmbedded(root, data.textContent ?? "");
  else void startPage(root);
}

// In a file without a server the script stands in the head and runs before the body is read.
if (document.readyState === "loading") addEventListener("DOMContentLoaded", start);
else start();
