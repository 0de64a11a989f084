/** Times to write on a ruler: round numbers, at most so many. */

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];

export function niceTicks(duration: number, most: number): number[] {
  const step = STEPS.find((one) => duration / one <= most) ?? duration;
  const ticks: number[] = [];
  for (let i = 0; i * step < duration - step * 0.3; i += 1) ticks.push(Number((i * step).toFixed(6)));
  return ticks;
}
