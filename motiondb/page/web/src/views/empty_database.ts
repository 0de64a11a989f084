/** What can be done with a database without captures. */

import { post } from "../api/client.ts";
import { isActive, stepOf } from "../api/jobs.ts";
import type { JobReply } from "../api/types.ts";
import { fill, h } from "../dom/element.ts";
import { progressBar } from "../parts/progress.ts";
import { emptyState } from "../parts/states.ts";
import { openAdding } from "./catalogue/adding.ts";
import type { Context } from "./view.ts";

/** The job that fills the database, if one is going on. */
export function fillingJob(context: Context): JobReply | undefined {
  return context.live.jobs().find((job) => ["add", "sample"].includes(job.kind) && isActive(job));
}

/** A state of a view that is made again with the news of jobs, as long as it is on screen. */
export function withJobs(context: Context, make: () => HTMLElement): HTMLElement {
  const element = h("div", make());
  const stop = context.live.listen((news) => {
    if (news.kind !== "job") return;
    if (element.isConnected) fill(element, make());
    else stop();
  });
  return element;
}

/** The state of a view while there is no capture. */
export const emptyDatabase = (context: Context): HTMLElement => withJobs(context, () => noCaptures(context));

function noCaptures(context: Context): HTMLElement {
  const job = fillingJob(context);
  if (job) {
    return emptyState("Adding captures…", [
      "They stand here as soon as they are saved.",
      progressBar(job.whole ?? null, stepOf(job)),
    ]);
  }
  if (context.status().read_only) return emptyState("This database is empty", "It was opened read-only.");
  const sample = (): void => void post("/api/add", { sample: true });
  return emptyState(
    "This database is empty",
    [
      "Drop motion-capture files or a folder anywhere on this page: BVH, FBX, ASF/AMC, C3D, npz and others.",
      h("br"),
      "Or look at what it does first, with synthetic captures that are shipped with motiondb.",
    ],
    [
      { label: "Try it with 101 sample captures", run: sample },
      { label: "Add captures", plain: true, run: () => openAdding(context) },
    ],
  );
}
