/** The sequence in the player, with its path on the ground and room for alternatives in the corners. */

import type { Track } from "../../api/container.ts";
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
/** Where the camera stands: angles in radians, distances in metres. Chosen by eye. */
const [AZIMUTH, ELEVATION, NEAR, FARTHEST] = [0.6, 0.45, 5.5, 6];
/** Seen from above, a path needs this much more distance than from the side. Chosen by eye. */
const FROM_ABOVE = 1.2;

export function makeScene(context: Context, corners: HTMLElement): Scene {
  const player = makePlayer(context.stage, { label: "The sequence" });
  const ribbon = makeRibbon(player.screen);
  player.element.querySelector(".player-stage")!.append(corners);
  let sequence: Sequence | null = null;
  let tracks: readonly Track[] | null = null;
  let region: readonly [number, number] | null = null;

  /** Loop and light the region, or everything; the time stays where it lies inside. */
  function loop(): void {
    if (!sequence || !tracks) return;
    const { screen } = player;
    const { time } = screen.playback;
    const lit = region ? timesOf(sequence.strip, ...region) : null;
    const part = lit ? { from: lit[0] - AROUND, to: lit[1] + AROUND } : {};
    screen.show({ tracks, lit, ...part });
    const { from, to } = screen.playback;
    if (time >= from && time < to) screen.setPlayback(seek(screen.playback, time));
  }

  /** The whole path where it is short enough; else the figure, from above so that its way is seen. */
  function look(): void {
    const { screen } = player;
    screen.setSwitches({ follow: false });
    screen.frameAll(AZIMUTH, ELEVATION);
    const { distance } = screen.orbit;
    if (distance > FARTHEST) screen.frameNow();
    const wanted = distance > FARTHEST ? NEAR : distance * FROM_ABOVE;
    screen.setOrbit({ ...screen.orbit, elevation: ELEVATION, distance: wanted });
  }

  return {
    element: player.element,
    player,
    async show(next, colours, keepCamera) {
      sequence = next;
      tracks = null;
      if (!keepCamera) player.say("Loading…");
      try {
        const got = await context.motions.tracks(next.ref);
        if (sequence !== next) return;
        tracks = got;
        player.show({ tracks }, true);
        ribbon.show(next, colours);
        if (!keepCamera) look();
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
      if (!tracks) return;
      ribbon.mark(next);
      loop();
    },
    rest() {
      sequence = region = tracks = null;
      player.show({ tracks: [] });
    },
    close() {
      ribbon.close();
      player.close();
    },
  };
}
