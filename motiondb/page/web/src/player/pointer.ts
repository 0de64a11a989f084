/** Turn, move and zoom the camera with mouse, pen or fingers. */

import { pixelsOf } from "../dom/wheel.ts";
import { pan, turn, zoom } from "./camera.ts";
import type { Screen } from "./screen.ts";

const TURN_PER_WIDTH = 2.4 * Math.PI;

/** Listen on the canvas of a screen. Dragging turns; with Shift or the right button it moves. */
export function steer(screen: Screen, wheel: boolean): void {
  const { canvas } = screen;
  const fingers = new Map<number, { x: number; y: number }>();
  canvas.style.touchAction = wheel ? "none" : "pan-y";

  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const dx = (event.clientX - finger.x) / canvas.clientHeight;
    const dy = (event.clientY - finger.y) / canvas.clientHeight;
    if (fingers.size === 2) pinch(event, finger, dx, dy);
    else if (event.shiftKey || event.buttons === 2) screen.setOrbit(pan(screen.orbit, -dx, dy));
    else screen.setOrbit(turn(screen.orbit, -dx * (TURN_PER_WIDTH / 2), dy * (TURN_PER_WIDTH / 3)));
    finger.x = event.clientX;
    finger.y = event.clientY;
  });

  function pinch(event: PointerEvent, finger: { x: number; y: number }, dx: number, dy: number): void {
    const other = [...fingers.values()].find((one) => one !== finger)!;
    const before = Math.hypot(finger.x - other.x, finger.y - other.y);
    const now = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    screen.setOrbit(zoom(pan(screen.orbit, -dx / 2, dy / 2), before / Math.max(now, 1)));
  }

  const lift = (event: PointerEvent): void => void fingers.delete(event.pointerId);
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener(
    "wheel",
    (event) => {
      // In a list the wheel scrolls the page; with Ctrl it zooms, as everywhere.
      if (!wheel && !event.ctrlKey) return;
      event.preventDefault();
      screen.setOrbit(zoom(screen.orbit, Math.exp(pixelsOf(event) * 0.0012)));
    },
    { passive: false },
  );
}
