/** Playback: time runs, and stops or starts again at the ends of a range. All times in seconds. */

export interface Playback {
  readonly time: number;
  readonly duration: number;
  /** The range that is played; the whole motion unless a part is looped. */
  readonly from: number;
  readonly to: number;
  readonly speed: number;
  readonly playing: boolean;
  readonly loop: boolean;
}

export const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2, 4] as const;

export function startPlayback(duration: number, from = 0, to = duration): Playback {
  return { time: from, duration, from, to, speed: 1, playing: false, loop: true };
}

/** Playback after some seconds of the wall clock. */
export function advance(playback: Playback, seconds: number): Playback {
  if (!playback.playing) return playback;
  const length = playback.to - playback.from;
  const time = playback.time + seconds * playback.speed;
  if (time < playback.to) return { ...playback, time };
  if (!playback.loop || length <= 0) return { ...playback, time: playback.to, playing: false };
  return { ...playback, time: playback.from + ((time - playback.from) % length) };
}

/** Playback moved to a time; a time outside the range is allowed, so that its surroundings can be seen. */
export function seek(playback: Playback, time: number): Playback {
  return { ...playback, time: Math.min(Math.max(time, 0), playback.duration) };
}

/** Playback moved by whole frames, and paused: a step shows one frame. */
export function step(playback: Playback, frames: number, fps: number): Playback {
  const frame = Math.round(playback.time * fps) + frames;
  const last = Math.max(Math.round(playback.duration * fps) - 1, 0);
  return { ...playback, playing: false, time: Math.min(Math.max(frame, 0), last) / fps };
}

/** Playing or paused; at the end of its range, playing begins again at the start of the range. */
export function toggle(playback: Playback): Playback {
  if (playback.playing) return { ...playback, playing: false };
  const ended = playback.time >= playback.to - 1e-6;
  return { ...playback, playing: true, time: ended ? playback.from : playback.time };
}

/** The next slower (-1) or faster (+1) speed. */
export function changeSpeed(playback: Playback, direction: 1 | -1): Playback {
  const at = SPEEDS.findIndex((speed) => speed >= playback.speed - 1e-9);
  const next = Math.min(Math.max(at + direction, 0), SPEEDS.length - 1);
  return { ...playback, speed: SPEEDS[next]! };
}
