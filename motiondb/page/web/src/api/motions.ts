/** Motions by name, each requested once: from the server, or from the data embedded in the page. */

import type { Motion } from "../player/motion.ts";
import { bytes } from "./client.ts";
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
const THUMBS_AT_ONCE = 100;

/** Motions from the server. */
export function serverMotions(): Motions {
  const takes = new Map<string, Promise<Track[]>>();
  const thumbs = new Map<string, Promise<Motion | null>>();
  const askThumb = batchedThumbs();
  return {
    tracks(ref, start, end) {
      const key = JSON.stringify([ref, start ?? null, end ?? null]);
      const known = takes.get(key);
      if (known) return known;
      const asked = bytes("/api/motion", { ref, start, end }).then(readContainer);
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

interface Waiting {
  name: string;
  resolve: (motion: Motion | null) => void;
  reject: (fault: unknown) => void;
}

/** Thumbnails that are requested at the same moment share one request. */
function batchedThumbs(): (name: string) => Promise<Motion | null> {
  let waiting: Waiting[] = [];
  async function flush(): Promise<void> {
    const batch = waiting.splice(0, THUMBS_AT_ONCE);
    if (waiting.length > 0) setTimeout(flush, 0);
    try {
      const tracks = readContainer(await bytes("/api/thumbs", { name: batch.map((one) => one.name) }));
      batch.forEach((one, i) => {
        const track = tracks[i];
        one.resolve(track?.kind === "body" && track.motion.frames > 0 ? track.motion : null);
      });
    } catch (fault) {
      batch.forEach((one) => one.reject(fault));
    }
  }
  return (name) =>
    new Promise((resolve, reject) => {
      waiting.push({ name, resolve, reject });
      if (waiting.length === 1) setTimeout(flush, 20);
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
