/** The entry of a file that carries its data, and needs no server. */

import { startEmbedded } from "./embedded/embedded.ts";

function start(): void {
  const data = document.getElementById("motiondb-data");
  startEmbedded(document.getElementById("app")!, data?.textContent ?? "");
}

if (document.readyState === "loading") addEventListener("DOMContentLoaded", start);
else start();
