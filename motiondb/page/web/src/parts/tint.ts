/**
 * A colour for every number: neighbours differ, and the same number always has the same colour.
 * The hue advances by the golden angle; lightness and chroma are even (OKLCH), so that no symbol
 * looks more important than another.
 */

const GOLDEN_ANGLE = 137.508;

export interface Tint {
  /** For fields with dark text on them. */
  soft: string;
  /** For lines and dots. */
  strong: string;
}

export function hueOf(number: number): number {
  return (number * GOLDEN_ANGLE + 20) % 360;
}

export function tintOf(number: number): Tint {
  return { soft: css(0.86, 0.075, hueOf(number)), strong: css(0.62, 0.13, hueOf(number)) };
}

/** Red, green and blue between 0 and 1 of an OKLCH colour (B. Ottosson, 2020), clipped to sRGB. */
export function rgbOf(lightness: number, chroma: number, degrees: number): [number, number, number] {
  const a = chroma * Math.cos((degrees * Math.PI) / 180);
  const b = chroma * Math.sin((degrees * Math.PI) / 180);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    display(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    display(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    display(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

function display(linear: number): number {
  const value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
  return Math.min(Math.max(value, 0), 1);
}

function css(lightness: number, chroma: number, degrees: number): string {
  const parts = rgbOf(lightness, chroma, degrees).map((part) => Math.round(part * 255));
  return `rgb(${parts.join(" ")})`;
}
