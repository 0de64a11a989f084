/** Motions by name, each requested once: from the server, or from the data embedded in the page. */

import type { Motion } from "../player/motion.ts";
import { bytes, postForBytes } from "./client.ts";
import { readContainer, type Track } from "./container.ts";

export interface Motions {
  /** All tracks of something that can be played, whole or in part. */
  tracks(ref: string, start?: number | null, end?: number | null): Promise<Track[]>;
  /** A few frames of a stored capture for its thumbnail; null where there are none. */
  thumb(name: string): Promise<Motion | null>;
  /** Drop everything that may have changed. */
  forget(): void;
}

const KEPT_TAKES = 80;
/** The first of many come sooner. Chosen by hand. */
const THUMBS_AT_ONCE = 12;
/** The server answers up to 64; fewer at once come sooner. Chosen by hand. */
const MOTIONS_AT_ONCE = 8;

/** Motions from the server. */
export function serverMotions(): Motions {
  const takes = new Map<string, Promise<Track[]>>();
  const thumbs = new Map<string, Promise<Motion | null>>();
  const askThumb = inBatches(THUMBS_AT_ONCE, 20, thumbsOf);
  const askPart = inBatches(MOTIONS_AT_ONCE, 0, partsOf);
  return {
    tracks(ref, start, end) {
      const key = JSON.stringify([ref, start ?? null, end ?? null]);
      const known = takes.get(key);
      if (known) return known;
      // A capture is one track, so that several fit into one answer; scenes have more.
      const asked = ref.startsWith("capture:")
        ? askPart({ ref, start: start ?? null, end: end ?? null })
        : bytes("/api/motion", { ref, start, end }).then(readContainer);
      asked.catch(() => takes.delete(key));
      takes.set(key, asked);
      if (takes.size > KEPT_TAKES) takes.delete(takes.keys().next().value!);
      return asked;
    },
    thumb(name) {
      let asked = thumbs.get(name);
      if (!asked) {
        asked = askThumb(name);
        asked.catch(() => thumbs.delete(name));
        thumbs.set(name, asked);
      }
      return asked;
    },
    forget() {
      takes.clear();
      thumbs.clear();
    },
  };
}

interface Part {
  ref: string;
  start: number | null;
  end: number | null;
}

async function thumbsOf(names: readonly string[]): Promise<(Motion | null)[]> {
  const tracks = readContainer(await bytes("/api/thumbs", { name: names }));
  return tracks.map((track) => (track.kind === "body" && track.motion.frames > 0 ? track.motion : null));
}

async function partsOf(items: readonly Part[]): Promise<Track[][]> {
  const alone = (part: Part): Promise<Track[]> => bytes("/api/motion", { ...part }).then(readContainer);
  if (items.length === 1) return [await alone(items[0]!)];
  return readContainer(await postForBytes("/api/motions", { items })).map((track) => [track]);
}

interface Waiting<Question, Answer> {
  question: Question;
  resolve: (answer: Answer) => void;
  reject: (fault: unknown) => void;
}

/** Questions that are asked within some milliseconds travel in one request. */
function inBatches<Question, Answer>(
  most: number,
  pause: number,
  ask: (questions: readonly Question[]) => Promise<readonly Answer[]>,
): (question: Question) => Promise<Answer> {
  let waiting: Waiting<Question, Answer>[] = [];
  async function flush(): Promise<void> {
    const batch = waiting.splice(0, most);
    if (waiting.length > 0) setTimeout(flush, 0);
    try {
      const answers = await ask(batch.map((one) => one.question));
      batch.forEach((one, i) => one.resolve(answers[i]!));
    } catch (fault) {
      if (batch.length === 1) return batch[0]!.reject(fault);
      // One that is refused must not take the others with it.
      for (const one of batch) ask([one.question]).then(([answer]) => one.resolve(answer!), one.reject);
    }
  }
  return (question) =>
    new Promise((resolve, reject) => {
      waiting.push({ question, resolve, reject });
      if (waiting.length === 1) setTimeout(flush, pause);
    });
}

/** Motions that are embedded in the page. */
export function embeddedMotions(containers: ReadonlyMap<string, () => ArrayBuffer>): Motions {
  const read = new Map<string, Track[]>();
  return {
    async tracks(ref) {
      let tracks = read.get(ref);
      if (!tracks) {
        const container = containers.get(ref);
        if (!container) throw new Error(`This file holds no motion of ${ref}.`);
        tracks = readContainer(container());
        read.set(ref, tracks);
      }
      return tracks;
    },
    async thumb() {
      return null;
    },
    forget() {},
  };
}
