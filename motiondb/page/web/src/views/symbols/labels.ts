/** Which words and figures fit at the dots of a map without covering one another. */

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

/** The box of a figure that stands on a dot. */
export const FIGURE = { width: 30, height: 46 };

/** Whether the figure and the word of each dot are drawn; earlier dots come first. */
export function placeMarks(dots: readonly Placed[]): { figures: boolean[]; words: boolean[] } {
  const taken: Box[] = [];
  const take = (box: Box): boolean => {
    const free = !taken.some((other) => overlap(box, other));
    if (free) taken.push(box);
    return free;
  };
  const figures = dots.map(({ x, y }) =>
    take({ left: x - FIGURE.width / 2, right: x + FIGURE.width / 2, top: y - FIGURE.height, bottom: y + 4 }),
  );
  const words = dots.map(({ x, y, radius, word }) => {
    if (!word) return false;
    const half = (word.length * LETTER) / 2;
    return take({ left: x - half, right: x + half, top: y + radius + 2, bottom: y + radius + 2 + LINE });
  });
  return { figures, words };
}
