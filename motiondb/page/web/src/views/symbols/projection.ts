/** From the symbol space to the picture: two of its axes, with one scale for both. */

export interface Axes {
  readonly first: number;
  readonly second: number;
  /** Pixels per unit of the space. */
  readonly scale: number;
  place(at: readonly number[]): [x: number, y: number];
}

export interface Size {
  width: number;
  height: number;
  margin: number;
}

/** Axes that fit all points into a picture; a space of one dimension lies on a line. */
export function fitAxes(
  points: readonly (readonly number[])[],
  first: number,
  second: number,
  size: Size,
): Axes {
  const xs = points.map((point) => point[first] ?? 0);
  const ys = points.map((point) => point[second] ?? 0);
  const [left, right] = [Math.min(...xs, 0), Math.max(...xs, 0)];
  const [low, high] = [Math.min(...ys, 0), Math.max(...ys, 0)];
  const scale = Math.min(
    (size.width - 2 * size.margin) / (right - left || 1),
    (size.height - 2 * size.margin) / (high - low || 1),
  );
  const middle: [number, number] = [(left + right) / 2, (low + high) / 2];
  return {
    first,
    second,
    scale,
    place: (at) => [
      size.width / 2 + ((at[first] ?? 0) - middle[0]) * scale,
      size.height / 2 - ((at[second] ?? 0) - middle[1]) * scale,
    ],
  };
}

/** How far a picture is enlarged, and where its middle was moved to, in its units. */
export interface Zoom {
  factor: number;
  x: number;
  y: number;
}

export const NO_ZOOM: Zoom = { factor: 1, x: 0, y: 0 };
const LARGEST_ZOOM = 12;

/** A zoom changed by a factor, so that a place of the picture stays where it is. */
export function zoomAt(zoom: Zoom, by: number, x: number, y: number, size: Size): Zoom {
  const factor = Math.min(Math.max(zoom.factor * by, 1), LARGEST_ZOOM);
  const grown = factor / zoom.factor;
  const [fromX, fromY] = [x - size.width / 2, y - size.height / 2];
  return { factor, x: fromX - (fromX - zoom.x) * grown, y: fromY - (fromY - zoom.y) * grown };
}

/** Axes as they lie in an enlarged picture. */
export function zoomed(axes: Axes, zoom: Zoom, size: Size): Axes {
  return {
    ...axes,
    scale: axes.scale * zoom.factor,
    place(at) {
      const [x, y] = axes.place(at);
      return [
        size.width / 2 + (x - size.width / 2) * zoom.factor + zoom.x,
        size.height / 2 + (y - size.height / 2) * zoom.factor + zoom.y,
      ];
    },
  };
}

/** Standard deviations that the ellipse of a cluster reaches. */
const DEVIATIONS = 2;

/** The ellipse of a Gaussian, projected on the axes of a picture. */
export function ellipseOf(mean: readonly number[], covariance: readonly (readonly number[])[], axes: Axes) {
  const { first, second, scale } = axes;
  const a = covariance[first]?.[first] ?? 0;
  const b = covariance[first]?.[second] ?? 0;
  const d = covariance[second]?.[second] ?? 0;
  const half = (a + d) / 2;
  const spread = Math.hypot((a - d) / 2, b);
  const [x, y] = axes.place(mean);
  return {
    x,
    y,
    rx: DEVIATIONS * Math.sqrt(Math.max(half + spread, 0)) * scale,
    ry: DEVIATIONS * Math.sqrt(Math.max(half - spread, 0)) * scale,
    /** Degrees, clockwise as in SVG. */
    angle: (-0.5 * Math.atan2(2 * b, a - d) * 180) / Math.PI,
  };
}
