/** A small player in a list: it plays an interval in a loop while it is on screen. */

import { REDUCED } from "../dom/wishes.ts";
import type { Track } from "../api/container.ts";
import type { Motions } from "../api/motions.ts";
import { messageOf } from "../api/client.ts";
import type { Motion } from "../player/motion.ts";
import { figureShades, litShades, paintPoster } from "../player/painter.ts";
import { h } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";
import { seek, toggle, type Playback } from "../player/playback.ts";
import { steer } from "../player/pointer.ts";
import { makeScreen, spanOf } from "../player/screen.ts";
import type { Stage } from "../player/stage.ts";

export interface ClipOptions {
  ref: string;
  label: string;
  /** The interval that is looped; the whole if absent. */
  part?: readonly [number, number];
  lit?: readonly [number, number] | null;
  onTime?(time: number): void;
  /** What is seen until it plays. */
  poster?: Motion | null;
}

/** Seconds around the interval that are loaded with it. */
const AROUND = 1;

/** Make a clip; it loads when it comes near the window. */
export function makeClip(context: { stage: Stage; motions: Motions }, options: ClipOptions) {
  const canvas = h("canvas.clip-canvas", { role: "img", "aria-label": options.label });
  const message = h("p.player-message", options.poster ? "" : "Loading…");
  const screen = makeScreen(context.stage, canvas);
  steer(screen, false);
  const button = h("button.clip-play.tool", { type: "button", on: { click: () => press() } });
  const element = h("div.clip", canvas, message, button);
  let tracks: readonly Track[] = [];

  let begun: Promise<void> | null = null;

  /** Play or pause; before the motion is there, play it as soon as it is. */
  function press(): void {
    if (tracks.length > 0) setPlayback(toggle(screen.playback));
    else void ready().then(() => setPlayback({ ...screen.playback, playing: true }));
  }

  function setPlayback(playback: Playback): void {
    screen.setPlayback(playback);
    refresh();
  }

  function refresh(): void {
    const { playing } = screen.playback;
    const label = `${playing ? "Pause" : "Play"}: ${options.label}`;
    button.setAttribute("aria-label", label);
    button.replaceChildren(icon(playing ? "pause" : "play"));
  }

  async function load(whole: boolean): Promise<void> {
    const { part } = options;
    try {
      tracks =
        whole || !part
          ? await context.motions.tracks(options.ref)
          : await context.motions.tracks(options.ref, Math.max(part[0] - AROUND, 0), part[1] + AROUND);
    } catch (fault) {
      message.textContent = messageOf(fault);
      return;
    }
    message.textContent = "";
    const [start, end] = spanOf(tracks);
    screen.show({ tracks, from: part?.[0] ?? start, to: part?.[1] ?? end, lit: options.lit ?? null });
  }

  async function begin(): Promise<void> {
    await load(false);
    screen.frameNow();
    setPlayback({ ...screen.playback, playing: !REDUCED.matches });
  }

  function ready(): Promise<void> {
    near.disconnect();
    begun ??= begin();
    return begun;
  }

  const near = new IntersectionObserver(
    (changes) => {
      if (!changes.some((change) => change.isIntersecting)) return;
      if (options.poster && tracks.length === 0)
        paintPoster(canvas, options.poster, options.lit ? litShades() : figureShades());
      void ready();
    },
    { rootMargin: "200px" },
  );
  near.observe(canvas);
  if (options.onTime) screen.onTime(options.onTime);
  refresh();

  async function goTo(time: number, playing: boolean): Promise<void> {
    await ready();
    const [start, end] = spanOf(tracks);
    if (time < start || time > end) await load(true);
    setPlayback({ ...seek(screen.playback, time), playing });
  }

  return {
    element,
    screen,
    /** Load what it plays, if that has not begun; ends when it is shown, or cannot be. */
    ready,
    /** Play from a time on. */
    playFrom: (time: number) => goTo(time, true),
    /** Show a time; a time outside the loaded part is loaded first. */
    seek: (time: number) => goTo(time, false),
    /** Play from the start. */
    replay(): void {
      const { playback } = screen;
      setPlayback({ ...seek(playback, playback.from), playing: true });
    },
    close(): void {
      near.disconnect();
      screen.close();
    },
  };
}

export type Clip = ReturnType<typeof makeClip>;
