/** Times to write on a ruler: round numbers, at most so many. */

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];

/** Those from one time to another, of a ruler with at most so many over the whole duration. */
export function niceTicks(duration: number, most: number, from = 0, to = duration): number[] {
  const step = STEPS.find((one) => duration / one <= most) ?? duration;
  const end = Math.min(to, duration - step * 0.3);
  const ticks: number[] = [];
  for (let i = Math.max(Math.ceil(from / step), 0); i * step < end; i += 1)
    ticks.push(Number((i * step).toFixed(6)));
  return ticks;
}
