/** Turns as unit quaternions, and directions as lists of three: as much as the mannequin needs. */

export type Vector = readonly [x: number, y: number, z: number];
export type Turn = readonly [x: number, y: number, z: number, w: number];

export const NO_TURN: Turn = [0, 0, 0, 1];

export function minus(a: Vector, b: Vector): Vector {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** The first plus a share of the second. */
export function plus(a: Vector, b: Vector, share = 1): Vector {
  return [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
}

export function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function lengthOf(a: Vector): number {
  return Math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/** The direction of a vector; of none, upwards. */
export function unit(a: Vector): Vector {
  const length = lengthOf(a);
  return length > 1e-9 ? [a[0] / length, a[1] / length, a[2] / length] : [0, 1, 0];
}

function normal([x, y, z, w]: Turn): Turn {
  const length = Math.sqrt(x * x + y * y + z * z + w * w);
  return [x / length, y / length, z / length, w / length];
}

/** First the second turn, then the first. */
export function after(a: Turn, b: Turn): Turn {
  return [
    a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    a[1] * b[3] + a[3] * b[1] + a[2] * b[0] - a[0] * b[2],
    a[2] * b[3] + a[3] * b[2] + a[0] * b[1] - a[1] * b[0],
    a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
  ];
}

export function back([x, y, z, w]: Turn): Turn {
  return [-x, -y, -z, w];
}

export function turned([x, y, z, w]: Turn, v: Vector): Vector {
  const twice = cross([x, y, z], v).map((value) => 2 * value) as unknown as Vector;
  return plus(plus(v, twice, w), cross([x, y, z], twice));
}

/** The least turn from one direction to another. */
export function between(a: Vector, b: Vector): Turn {
  const w = 1 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  if (w > 1e-6) return normal([...cross(a, b), w]);
  return normal(Math.abs(a[0]) > Math.abs(a[2]) ? [-a[1], a[0], 0, 0] : [0, -a[2], a[1], 0]);
}

export function about(axis: Vector, angle: number): Turn {
  const s = Math.sin(angle / 2);
  return [s * axis[0], s * axis[1], s * axis[2], Math.cos(angle / 2)];
}

/** Half-way between two turns. */
export function halfway(a: Turn, b: Turn): Turn {
  const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
  return normal([a[0] + sign * b[0], a[1] + sign * b[1], a[2] + sign * b[2], a[3] + sign * b[3]]);
}

/** The turn of a frame whose y axis is `up`, and whose x axis is as near to `left` as it can be. */
export function upright(left: Vector, up: Vector): Turn {
  const y = unit(up);
  const swing = between([0, 1, 0], y);
  const ahead = unit(cross(left, y));
  const [x, , z] = turned(back(swing), ahead);
  return after(swing, about([0, 1, 0], Math.atan2(x, z)));
}
