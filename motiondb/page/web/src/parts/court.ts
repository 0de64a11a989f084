/** The lines of a basketball court, for the board from above and for the player. */

/** A place: [x, z] in metres, the rim at [0, 0]. */
type Spot = [x: number, z: number];

/** The lines of a half court: key, its circle, three-point line, no-charge and centre circle (FIBA, article 2). */
export function courtLines({ behind_rim, length }: { behind_rim: number; length: number }): Spot[][] {
  const arc = (radius: number, first: number, last: number, z: number): Spot[] =>
    Array.from({ length: 73 }, (_, i) => {
      const angle = ((first + ((last - first) * i) / 72) * Math.PI) / 180;
      return [radius * Math.cos(angle), z + radius * Math.sin(angle)];
    });
  const [base, free, middle] = [-behind_rim, 5.8 - behind_rim, length - behind_rim];
  const turn = (Math.atan2(Math.sqrt(6.75 ** 2 - 6.6 ** 2), 6.6) * 180) / Math.PI;
  return [
    [
      [-2.45, base],
      [-2.45, free],
      [2.45, free],
      [2.45, base],
    ],
    arc(1.8, 0, 180, free),
    [[6.6, base], ...arc(6.75, turn, 180 - turn, 0), [-6.6, base]],
    arc(1.25, 0, 180, 0),
    arc(1.8, 180, 360, middle),
    [
      [-0.9, -0.375],
      [0.9, -0.375],
    ],
  ];
}
