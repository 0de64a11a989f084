/** What is known of long work, and how it is ended. */

import { onPage } from "./advice.ts";
import { remove } from "./client.ts";
import type { JobReply } from "./types.ts";

export const isActive = (job: JobReply): boolean => job.state === "running" || job.state === "waiting";

/** What a job does at present. */
export const stepOf = ({ what, state }: JobReply): string =>
  what ||
  { waiting: "waiting", running: "starting", done: "done", failed: "failed", cancelled: "cancelled" }[state];

export const cancelJob = (job: JobReply): Promise<unknown> =>
  remove(`/api/jobs/${encodeURIComponent(job.id)}` as "/api/jobs/{job_id}");

/** Why a job failed, as advice for this page. */
export const failureOf = (job: JobReply): string => onPage(job.message ?? "It failed.");
