/** Which words fit beside the dots of a map without covering one another. */

export interface Placed {
  x: number;
  y: number;
  radius: number;
  word: string;
}

/** Width of a letter and height of a line, pixels, of the map's type. Estimated. */
const LETTER = 7.2;
const LINE = 14;

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

const overlap = (a: Box, b: Box): boolean =>
  a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;

/** Whether the word of each dot is written; earlier dots come first. */
export function wordsThatFit(dots: readonly Placed[]): boolean[] {
  const bodies = dots.map(({ x, y, radius }): Box => ({
    left: x - radius,
    right: x + radius,
    top: y - radius,
    bottom: y + radius,
  }));
  const written: Box[] = [];
  return dots.map(({ x, y, radius, word }, i) => {
    if (!word) return false;
    const half = (word.length * LETTER) / 2;
    const box: Box = { left: x - half, right: x + half, top: y + radius + 2, bottom: y + radius + 2 + LINE };
    const free =
      !written.some((other) => overlap(box, other)) &&
      !bodies.some((other, j) => j !== i && overlap(box, other));
    if (free) written.push(box);
    return free;
  });
}
