/** The player: a screen with its buttons, its keys and the time. */

import { button } from "../dom/button.ts";
import { fill, h } from "../dom/element.ts";
import { icon, type IconName } from "../dom/icons.ts";
import { pan, turn, zoom } from "./camera.ts";
import { castColours } from "./cast_colours.ts";
import { advance, changeSpeed, seek, SPEEDS, step, toggle } from "./playback.ts";
import { steer } from "./pointer.ts";
import { makeScreen, spanOf, type Shown, type Switches } from "./screen.ts";
import type { Stage } from "./stage.ts";
import { showKeys } from "./keys.ts";
import { makeNames } from "./names.ts";

export interface PlayerOptions {
  label: string;
  /** Frames per second that a step moves by. */
  fps?: number;
}

/** A camera farther away than this shows a figure too small, metres. Chosen by eye. */
const FAR = 7;

const SWITCHES: readonly [keyof Switches, IconName, string][] = [
  ["follow", "follow", "Follow the figure (F)"],
  ["grid", "grid", "Grid (G)"],
  ["trails", "trails", "Trails of hands and feet (T)"],
  ["contacts", "contact", "Feet on the ground (C)"],
  ["turntable", "turntable", "Go around them (V)"],
];

function tool(name: IconName, label: string, click: () => void): HTMLButtonElement {
  return button("tool", icon(name), click, { "aria-label": label, title: label });
}

/** Make a player. */
export function makePlayer(stage: Stage, options: PlayerOptions) {
  const canvas = h("canvas.player-canvas", {
    tabindex: 0,
    role: "img",
    "aria-label": options.label,
  });
  const message = h("p.player-message", { role: "status" });
  const screen = makeScreen(stage, canvas);
  const fps = options.fps ?? 30;
  steer(screen, true);
  const names = makeNames(screen);

  const playButton = tool("play", "Play (Space)", () => change("toggle"));
  const readout = h("output.player-time", { "aria-live": "off" });
  const slider = h("input.player-slider", {
    type: "range",
    min: 0,
    max: 1,
    step: "any",
    value: 0,
    "aria-label": "Time",
    on: {
      input: () => screen.setPlayback({ ...seek(screen.playback, Number(slider.value)), playing: false }),
    },
  });
  const speed = h(
    "select.player-speed",
    {
      "aria-label": "Speed",
      title: "Speed (up, down)",
      on: { change: () => screen.setPlayback({ ...screen.playback, speed: Number(speed.value) }) },
    },
    SPEEDS.map((one) => h("option", { value: one, selected: one === 1 }, `${one}×`)),
  );
  const loopButton = tool("loop", "Loop (L)", () => change("loop"));
  const switchButtons = SWITCHES.map(([name, picture, label]) => tool(picture, label, () => change(name)));
  const element = h(
    "section.player",
    { "aria-label": options.label },
    h("div.player-stage", canvas, names.element, message),
    slider,
    h(
      "div.player-bar",
      tool("back", "One frame back (left)", () => stepBy(-1)),
      playButton,
      tool("forward", "One frame forward (right)", () => stepBy(1)),
      readout,
      speed,
      loopButton,
      ...switchButtons,
      tool("camera", "See everything (R)", () => screen.frameAll()),
      tool("full", "Full screen", () => void toggleFull()),
      tool("help", "Keys of the player (?)", () => showKeys(element)),
    ),
  );

  function toggleFull(): Promise<void> {
    return document.fullscreenElement ? document.exitFullscreen() : element.requestFullscreen();
  }

  function stepBy(frames: number): void {
    screen.setPlayback(step(screen.playback, frames, fps));
  }

  function change(what: "toggle" | "loop" | keyof Switches): void {
    const { playback, switches } = screen;
    if (what === "toggle") screen.setPlayback(toggle(playback));
    else if (what === "loop") screen.setPlayback({ ...playback, loop: !playback.loop });
    else screen.setSwitches({ [what]: !switches[what] });
    refresh();
  }

  let wasPlaying: boolean | null = null;
  function refresh(): void {
    const { playback, switches } = screen;
    if (playback.playing !== wasPlaying) {
      wasPlaying = playback.playing;
      fill(playButton, icon(playback.playing ? "pause" : "play"));
      playButton.setAttribute("aria-label", playback.playing ? "Pause (Space)" : "Play (Space)");
    }
    loopButton.setAttribute("aria-pressed", String(playback.loop));
    SWITCHES.forEach(([name], i) => switchButtons[i]!.setAttribute("aria-pressed", String(switches[name])));
    speed.value = String(playback.speed);
    tell(playback.time);
  }

  function tell(time: number): void {
    slider.value = String(time);
    const frame = Math.floor(time * fps + 1e-6);
    readout.textContent = `${time.toFixed(2)} / ${screen.playback.duration.toFixed(2)} s`;
    readout.title = `frame ${frame}`;
    slider.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds, frame ${frame}`);
    if (screen.playback.playing !== wasPlaying) refresh();
  }

  const KEYS: Record<string, () => void> = {
    " ": () => change("toggle"),
    ArrowLeft: () => stepBy(-1),
    ArrowRight: () => stepBy(1),
    ArrowUp: () => screen.setPlayback(changeSpeed(screen.playback, 1)),
    ArrowDown: () => screen.setPlayback(changeSpeed(screen.playback, -1)),
    Home: () => screen.setPlayback(seek(screen.playback, screen.playback.from)),
    End: () => screen.setPlayback(seek(screen.playback, screen.playback.to)),
    l: () => change("loop"),
    f: () => change("follow"),
    g: () => change("grid"),
    t: () => change("trails"),
    c: () => change("contacts"),
    v: () => change("turntable"),
    r: () => screen.frameAll(),
    "1": () => screen.frameAll(0, 0.05),
    "2": () => screen.frameAll(Math.PI / 2, 0.05),
    "3": () => screen.frameAll(0, 1.5),
    a: () => screen.setOrbit(turn(screen.orbit, -0.15, 0)),
    d: () => screen.setOrbit(turn(screen.orbit, 0.15, 0)),
    w: () => screen.setOrbit(turn(screen.orbit, 0, 0.1)),
    s: () => screen.setOrbit(turn(screen.orbit, 0, -0.1)),
    "+": () => screen.setOrbit(zoom(screen.orbit, 0.88)),
    "-": () => screen.setOrbit(zoom(screen.orbit, 1.14)),
    ",": () => screen.setOrbit(pan(screen.orbit, -0.05, 0)),
    ".": () => screen.setOrbit(pan(screen.orbit, 0.05, 0)),
    "?": () => showKeys(element),
  };
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const typed = event.target as HTMLElement;
    if (typed !== canvas && typed.matches("input, select, button, dialog *")) return;
    const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
    refresh();
  });
  screen.onTime(tell);
  refresh();

  return {
    element,
    screen,
    show(shown: Shown, keepCamera = false): void {
      const colours = shown.colours ?? castColours(shown.tracks);
      screen.show({ ...shown, ...(colours ? { colours } : {}) });
      names.show(shown.tracks, shown.shifts);
      const [start, end] = spanOf(shown.tracks);
      slider.min = String(start);
      slider.max = String(end);
      if (!keepCamera) {
        screen.frameAll();
        // Far away figures are too small to be read: stay near one that walks a long way.
        if (screen.orbit.distance > FAR && shown.tracks.length === 1) screen.frameNow();
      }
      message.textContent = "";
      refresh();
    },
    play(): void {
      screen.setPlayback({ ...advance(screen.playback, 0), playing: true });
      refresh();
    },
    seek: (time: number) => screen.setPlayback(seek(screen.playback, time)),
    onTime: (listener: (time: number) => void) => screen.onTime(listener),
    /** A message over the picture; an empty one removes it. */
    say: (text: string) => void (message.textContent = text),
    close: () => screen.close(),
  };
}

export type Player = ReturnType<typeof makePlayer>;
