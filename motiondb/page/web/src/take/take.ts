/** A take: the player, its timeline, and a part that is selected by dragging and then looped. */

import { REDUCED } from "../dom/wishes.ts";
import type { Track } from "../api/container.ts";
import type { Ghost } from "../api/types.ts";
import type { Motions } from "../api/motions.ts";
import { messageOf } from "../api/client.ts";
import { fill, h, type Child } from "../dom/element.ts";
import { makePlayer, type Player } from "../player/player.ts";
import { makeGhosts } from "../player/ghosts.ts";
import { spanOf } from "../player/screen.ts";
import { seek } from "../player/playback.ts";
import type { Stage } from "../player/stage.ts";
import type { Lane } from "../timeline/lanes.ts";
import { makeTimeline, type Interval, type Timeline } from "../timeline/timeline.ts";
import { makePartBar } from "./part_bar.ts";

export interface TakeContents {
  ref: string;
  /** The lanes that are known at the start; others can be set later with `setLanes`. */
  lanes?: readonly Lane[];
  selection?: Interval | null;
}

export interface Take {
  readonly element: HTMLElement;
  readonly player: Player;
  load(contents: TakeContents): Promise<void>;
  setLanes(lanes: readonly Lane[]): void;
  /** Boxes for what was not captured. */
  setGhosts(ghosts: readonly Ghost[]): void;
  readonly selection: Interval | null;
  select(selection: Interval | null): void;
  close(): void;
}

export interface TakeOptions {
  label: string;
  /** Actions for a selected part, shown beside its times. */
  partActions?: readonly { label: string; run: (part: Interval) => void }[];
  /** More beside the times of a selected part. */
  partMore?: Child;
  onSelect?(selection: Interval | null): void;
}

/** Make a take; it is empty until something is loaded. */
export function makeTake(context: { stage: Stage; motions: Motions }, options: TakeOptions): Take {
  const player = makePlayer(context.stage, { label: options.label });
  const ghosts = makeGhosts(player.screen);
  const timelineBox = h("div");
  const partBar = makePartBar(options.partActions ?? [], (part) => select(part), options.partMore);
  const element = h("div.take", player.element, timelineBox, partBar.element);
  let timeline: Timeline | null = null;
  let lanes: readonly Lane[] = [];
  let selection: Interval | null = null;
  let loaded = "";

  player.onTime((time) => timeline?.setTime(time));

  function loop(): void {
    const { screen } = player;
    const [from, to] = selection ?? [0, screen.playback.duration];
    const next = { ...screen.playback, from, to };
    const outside = next.time < from || next.time >= to;
    screen.setPlayback(outside ? seek(next, from) : next);
  }

  function select(next: Interval | null): void {
    selection = next;
    timeline?.setSelection(next);
    partBar.show(next, player.screen.playback.duration);
    loop();
    options.onSelect?.(next);
  }

  async function load(contents: TakeContents): Promise<void> {
    if (loaded !== contents.ref) ghosts.show([]);
    loaded = contents.ref;
    lanes = contents.lanes ?? [];
    player.say("Loading…");
    let tracks: Track[];
    try {
      tracks = await context.motions.tracks(contents.ref);
    } catch (fault) {
      if (loaded === contents.ref) player.say(messageOf(fault));
      return;
    }
    if (loaded !== contents.ref) return;
    const [from, to] = spanOf(tracks);
    player.show({ tracks, from, to, lit: contents.selection ?? null });
    timeline = makeTimeline({
      duration: to,
      label: `Timeline of ${options.label}`,
      onSeek: (time) => player.seek(time),
      onSelect: select,
    });
    timeline.setLanes(lanes);
    fill(timelineBox, timeline.element);
    select(contents.selection ?? null);
    if (contents.selection) player.screen.frameNow();
    if (!REDUCED.matches) player.play();
  }

  return {
    element,
    player,
    load,
    setLanes(next) {
      lanes = next;
      timeline?.setLanes(next);
    },
    setGhosts: (next) => ghosts.show(next),
    get selection() {
      return selection;
    },
    select,
    close() {
      ghosts.close();
      player.close();
    },
  };
}
