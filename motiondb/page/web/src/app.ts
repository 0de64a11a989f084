/** The entry of the page of a server. */

import { startPage } from "./shell/page.ts";

void startPage(document.getElementById("app")!);
