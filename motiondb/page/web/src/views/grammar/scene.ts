/** The sequence in the player, with its path on the ground and room for alternatives in the corners. */

import { REDUCED } from "../../dom/wishes.ts";
import type { Track } from "../../api/container.ts";
import { messageOf } from "../../api/client.ts";
import { makePlayer } from "../../player/player.ts";
import { seek } from "../../player/playback.ts";
import type { Context } from "../view.ts";
import type { TerminalColours } from "./colours.ts";
import { timesOf } from "./layout.ts";
import { makeRibbon } from "./ribbon.ts";
import type { SequenceReply } from "../../api/types.ts";

/** Seconds around a region that are looped with it: the seams are seen. */
const AROUND = 0.4;
/** Where the camera stands above the ground, radians, and from a figure, metres. Chosen by eye. */
const [ELEVATION, NEAR] = [0.45, 5.5];
/** Seen from above, a path needs this much more distance than from the side. Chosen by eye. */
const FROM_ABOVE = 1.2;

export function makeScene(context: Context, corners: HTMLElement) {
  const player = makePlayer(context.stage, { label: "The sequence" });
  const ribbon = makeRibbon(player.screen);
  player.element.querySelector(".player-stage")!.append(corners);
  let sequence: SequenceReply | null = null;
  let tracks: readonly Track[] | null = null;
  let region: readonly [number, number] | null = null;

  /** Loop the region, or everything; a time inside the loop does not change. */
  function loop(): void {
    if (!sequence || !tracks) return;
    const { screen } = player;
    const { duration } = screen.playback;
    const [from, to] = region ? timesOf(sequence.strip, ...region) : [0, duration];
    const around = region ? AROUND : 0;
    const part = { from: Math.max(from - around, 0), to: Math.min(to + around, duration) };
    const next = { ...screen.playback, ...part };
    const outside = next.time < next.from || next.time >= next.to;
    screen.setPlayback(outside ? seek(next, next.from) : next);
  }

  /** Show the path of the figure from above. */
  function rise(): void {
    const { screen } = player;
    const distance = screen.switches.follow ? NEAR : screen.orbit.distance * FROM_ABOVE;
    screen.setOrbit({ ...screen.orbit, elevation: ELEVATION, distance });
  }

  /** Begin at an edit, with the camera unchanged; a following camera moves with the figure. */
  function goTo(time: number): void {
    const { screen } = player;
    const { azimuth, elevation, distance } = screen.orbit;
    player.seek(time);
    if (!screen.switches.follow) return;
    screen.frameNow();
    screen.setOrbit({ ...screen.orbit, azimuth, elevation, distance });
  }

  return {
    element: player.element,
    player,
    /** Play a sequence; after an edit the camera stays and the time goes on at the edit. */
    async show(next: SequenceReply, colours: TerminalColours, keepCamera: boolean): Promise<void> {
      sequence = next;
      tracks = null;
      if (!keepCamera) player.say("Loading…");
      try {
        const got = await context.motions.tracks(next.ref);
        if (sequence !== next) return;
        tracks = got;
        player.show({ tracks }, keepCamera);
        ribbon.show(next, colours);
        if (!keepCamera) rise();
        if (next.edited && keepCamera) goTo(timesOf(next.strip, next.edited.start, next.edited.end)[0]);
        if (region) ribbon.mark(region);
        loop();
        if (!REDUCED.matches) player.play();
      } catch (fault) {
        if (sequence === next) player.say(messageOf(fault));
      }
    },
    /** Loop the terminals of a region; null: everything. */
    mark(next: readonly [start: number, end: number] | null): void {
      region = next;
      if (!tracks) return;
      ribbon.mark(next);
      loop();
    },
    /** Show nothing. */
    rest(): void {
      sequence = region = tracks = null;
      player.show({ tracks: [] });
    },
    close(): void {
      ribbon.close();
      player.close();
    },
  };
}

export type Scene = ReturnType<typeof makeScene>;
