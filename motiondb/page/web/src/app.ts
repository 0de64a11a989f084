/** The entry: a page of a server, or a file that carries its data. */

import { startEmbedded } from "./embedded/embedded.ts";
import { startPage } from "./shell/page.ts";

const root = document.getElementById("app")!;
const data = document.getElementById("motiondb-data");
if (data) startEmbedded(root, data.textContent ?? "");
else void startPage(root);
