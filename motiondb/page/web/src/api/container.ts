/** Read the binary container of motions: a JSON header, then 16-bit integers. */

import type { BallMotion, Motion } from "../player/motion.ts";

interface TrackHeader {
  name: string;
  ref?: string;
  kind: "body" | "ball";
  team?: string | null;
  frames: number;
  fps: number;
  start: number;
  offset: number;
  origin: [number, number, number];
  scale: [number, number, number];
  contacts: number | null;
  moment?: number | null;
  radius?: number;
}

interface Header {
  format: number;
  points: string[];
  parents: number[];
  radii: number[];
  tracks: TrackHeader[];
}

export interface BodyTrack {
  kind: "body";
  name: string;
  ref: string | null;
  team: string | null;
  motion: Motion;
}

export interface BallTrack {
  kind: "ball";
  name: string;
  motion: BallMotion;
}

export type Track = BodyTrack | BallTrack;

/** The tracks of a container. Throws where the bytes are not one. */
export function readContainer(buffer: ArrayBuffer): Track[] {
  const view = new DataView(buffer);
  if (buffer.byteLength < 8 || view.getUint32(0, false) !== 0x4d44424d) {
    throw new Error("The motion that the server sent cannot be read: it does not begin with MDBM.");
  }
  const length = view.getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length))) as Header;
  if (header.format !== 1) {
    throw new Error(`The motion has format ${header.format}; this page reads format 1. Reload the page.`);
  }
  const payload = 8 + length;
  return header.tracks.map((track) => readTrack(buffer, payload, header, track));
}

function readTrack(buffer: ArrayBuffer, payload: number, header: Header, track: TrackHeader): Track {
  const { frames, fps, start, name } = track;
  const points = track.kind === "ball" ? 1 : header.points.length;
  const positions = decode(buffer, payload + track.offset, frames * points, track);
  if (track.kind === "ball") {
    return { kind: "ball", name, motion: { fps, frames, start, positions, radius: track.radius ?? 0.12 } };
  }
  const contacts = track.contacts === null ? null : new Uint8Array(buffer, payload + track.contacts, frames);
  const { parents, radii } = header;
  const { points: names } = header;
  const moment = track.moment ?? null;
  const motion = { fps, frames, start, points: names, parents, radii, positions, contacts, moment };
  return { kind: "body", name, ref: track.ref ?? null, team: track.team ?? null, motion };
}

function decode(buffer: ArrayBuffer, at: number, count: number, track: TrackHeader): Float32Array {
  const values = new Int16Array(buffer.slice(at, at + count * 6));
  const positions = new Float32Array(count * 3);
  for (let i = 0; i < positions.length; i += 1) {
    const axis = i % 3;
    positions[i] = track.origin[axis]! + track.scale[axis]! * values[i]!;
  }
  return positions;
}

/** The bytes of base64 text. */
export function fromBase64(text: string): ArrayBuffer {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i += 1) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
