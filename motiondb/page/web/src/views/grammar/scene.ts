/** The sequence in the player, with its path on the ground and room for alternatives in the corners. */

import { messageOf } from "../../api/client.ts";
import { makePlayer, type Player } from "../../player/player.ts";
import { seek } from "../../player/playback.ts";
import type { Context } from "../view.ts";
import type { TerminalColours } from "./colours.ts";
import { timesOf } from "./layout.ts";
import { makeRibbon } from "./ribbon.ts";
import type { Sequence } from "./types.ts";

export interface Scene {
  readonly element: HTMLElement;
  readonly player: Player;
  /** Play a sequence; after an edit the camera stays and the time goes on at the edit. */
  show(sequence: Sequence, colours: TerminalColours, keepCamera: boolean): Promise<void>;
  /** Loop the terminals of a region; null: everything. */
  mark(region: readonly [start: number, end: number] | null): void;
  /** Show nothing. */
  rest(): void;
  close(): void;
}

const REDUCED = matchMedia("(prefers-reduced-motion: reduce)");
/** Seconds around a region that are looped with it: the seams are seen. */
const AROUND = 0.4;

export function makeScene(context: Context, corners: HTMLElement): Scene {
  const player = makePlayer(context.stage, { label: "The sequence" });
  const ribbon = makeRibbon(player.screen);
  player.element.querySelector(".player-stage")!.append(corners);
  let sequence: Sequence | null = null;
  let loaded = false;
  let region: readonly [number, number] | null = null;

  function loop(): void {
    if (!sequence || !loaded) return;
    const { screen } = player;
    const { duration } = screen.playback;
    const [from, to] = region ? timesOf(sequence.strip, ...region) : [0, duration];
    const around = region ? AROUND : 0;
    const part = { from: Math.max(from - around, 0), to: Math.min(to + around, duration) };
    const next = { ...screen.playback, ...part };
    const outside = next.time < next.from || next.time >= next.to;
    screen.setPlayback(outside ? seek(next, next.from) : next);
  }

  return {
    element: player.element,
    player,
    async show(next, colours, keepCamera) {
      sequence = next;
      loaded = false;
      if (!keepCamera) player.say("Loading…");
      try {
        const tracks = await context.motions.tracks(next.ref);
        if (sequence !== next) return;
        player.show({ tracks }, keepCamera);
        ribbon.show(next, colours);
        loaded = true;
        if (next.edited && keepCamera)
          player.seek(timesOf(next.strip, next.edited.start, next.edited.end)[0]);
        if (region) ribbon.mark(region);
        loop();
        if (!REDUCED.matches) player.play();
      } catch (fault) {
        if (sequence === next) player.say(messageOf(fault));
      }
    },
    mark(next) {
      region = next;
      if (!loaded) return;
      ribbon.mark(next);
      loop();
    },
    rest() {
      sequence = region = null;
      loaded = false;
      player.show({ tracks: [] });
    },
    close() {
      ribbon.close();
      player.close();
    },
  };
}
