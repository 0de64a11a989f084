/** News from the server: the database changed, a job went on. */

import { get } from "./client.ts";
import type { JobReply } from "./types.ts";

export type News =
  | { kind: "revision"; revision: number }
  | { kind: "job"; job: JobReply }
  /** Jobs are gone: the server was started again. */
  | { kind: "forgotten"; jobs: readonly string[] }
  | { kind: "connection"; open: boolean };

/** Listen to the server; jobs that began before this page was loaded are requested. */
export function openLive() {
  const listeners = new Set<(news: News) => void>();
  const jobs = new Map<string, JobReply>();
  const tell = (news: News): void => listeners.forEach((listener) => listener(news));
  const learn = (job: JobReply): void => {
    jobs.set(job.id, job);
    tell({ kind: "job", job });
  };
  let source: EventSource | null = null;

  function connect(): void {
    source?.close();
    source = new EventSource("/api/events");
    source.addEventListener("revision", (event) =>
      tell({ kind: "revision", ...(JSON.parse(event.data) as { revision: number }) }),
    );
    source.addEventListener("job", (event) => learn(JSON.parse(event.data) as JobReply));
    source.addEventListener("open", () => {
      tell({ kind: "connection", open: true });
      get("/api/jobs").then(
        (answer) => {
          const known = new Set(answer.jobs.map((job) => job.id));
          const gone = [...jobs.keys()].filter((id) => !known.has(id));
          gone.forEach((id) => jobs.delete(id));
          if (gone.length > 0) tell({ kind: "forgotten", jobs: gone });
          answer.jobs.forEach(learn);
        },
        () => undefined, // the next opening asks again
      );
    });
    source.addEventListener("error", () => tell({ kind: "connection", open: false }));
  }

  // A browser opens only a few connections to one server: a hidden tab closes its own.
  document.addEventListener("visibilitychange", () => (document.hidden ? source?.close() : connect()));
  addEventListener("pagehide", () => source?.close());
  addEventListener("pageshow", (event) => event.persisted && connect());
  connect();
  return {
    /** Call a listener with every piece of news; returns a function that stops this. */
    listen(listener: (news: News) => void): () => void {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
    /** The jobs that the server knows, newest first. */
    jobs: () => [...jobs.values()].sort((a, b) => (b.started ?? Infinity) - (a.started ?? Infinity)),
  };
}

export type Live = ReturnType<typeof openLive>;
