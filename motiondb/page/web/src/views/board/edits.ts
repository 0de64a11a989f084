/** Changes of a diagram; every function returns a new diagram. */

import type { DiagramShape, ElementShape, Ground, PlayerShape } from "../../api/types.ts";
import type { Spot, Team } from "./spot.ts";

export const MOVES: readonly string[] = ["move", "walk", "run", "cut", "dribble"];
export const SHOTS: readonly string[] = ["shoot", "layup"];
export const FEINTS: readonly string[] = ["feint", "fake", "pivot_left", "pivot_right"];
export const STANDS: readonly string[] = ["guard", "block"];

/** Kinds that end at a place of the ground. */
export const endsAtPlace = (kind: string): boolean =>
  MOVES.includes(kind) || kind === "screen" || kind === "feint";

/** Kinds that need another player. */
export const needsOther = (kind: string): boolean =>
  kind === "pass" || kind === "screen" || STANDS.includes(kind);

/** The selection on the board: a player, a place, or an element with one of its points. */
export type Selection =
  | { what: "player"; name: string }
  | { what: "place"; name: string }
  | { what: "element"; index: number; point: "end" | number | null }
  | null;

/** A place rounded to centimetres and kept on the court. */
export function onCourt([x, z]: Spot, { court }: DiagramShape): Spot {
  const keep = (value: number, least: number, most: number): number =>
    Math.round(Math.min(Math.max(value, least), most) * 100) / 100;
  return [
    keep(x, -court.width / 2, court.width / 2),
    keep(z, -court.behind_rim, court.length - court.behind_rim),
  ];
}

/** Size of a new ground without the lines of a court, metres. */
const FIELD = { width: 8, length: 6 };

/** A new diagram: two attackers on a half court, or one person on the ground of another activity. */
export function emptyDiagram(ground: Ground | null = null): DiagramShape {
  const court = { width: 15, length: 14, behind_rim: 1.575, lines: true };
  if (ground && !ground.teams.includes("attack")) return emptyField(ground);
  return {
    title: "New play",
    grammar: ground?.grammar ?? "basketball",
    ball: "",
    court,
    places: [{ name: "rim", at: [0, 0] }],
    players: [
      { name: "A1", team: "attack", at: [0, 8], guards: "" },
      { name: "A2", team: "attack", at: [-4.8, 5.6], guards: "" },
    ],
    elements: [],
  };
}

/** A ground with the places that its grammar names, from the left to the right. */
function emptyField(ground: Ground): DiagramShape {
  const { width, length } = FIELD;
  const apart = width / (ground.places.length + 1);
  const at = (i: number): Spot => [Math.round((apart * (i + 1) - width / 2) * 10) / 10, 0];
  const names = ground.places.length ? ground.places : [];
  const first: Spot = names.length ? at(0) : [0, 0];
  return {
    title: `New ${ground.grammar}`,
    grammar: ground.grammar,
    ball: "",
    court: { width, length, behind_rim: length / 2, lines: false },
    places: [{ name: "rim", at: [0, 0] as Spot }, ...names.map((name, i) => ({ name, at: at(i) }))],
    players: [{ name: "P1", team: "player", at: first, guards: "" }],
    elements: [],
  };
}

/** A diagram without players: that of a text that cannot be read. */
export function blankDiagram(): DiagramShape {
  return { ...emptyDiagram(), title: "", players: [] };
}

const PREFIXES: Record<Team, string> = { attack: "A", defence: "D", player: "P" };

export function addPlayer(diagram: DiagramShape, team: Team, at: Spot): [DiagramShape, string] {
  const taken = new Set(diagram.players.map((one) => one.name));
  let number = 1;
  while (taken.has(`${PREFIXES[team]}${number}`)) number += 1;
  const name = `${PREFIXES[team]}${number}`;
  const player: PlayerShape = { name, team, at: onCourt(at, diagram), guards: "" };
  if (team === "defence") player.guards = nearest(diagram, at, "attack") ?? "";
  return [{ ...diagram, players: [...diagram.players, player] }, name];
}

/** The name of the player of a team who stands nearest to a place at the beginning. */
export function nearest(diagram: DiagramShape, [x, z]: Spot, team: Team): string | null {
  const apart = (one: PlayerShape): number => Math.hypot(one.at[0] - x, one.at[1] - z);
  const members = diagram.players.filter((one) => one.team === team);
  return members.sort((a, b) => apart(a) - apart(b))[0]?.name ?? null;
}

export function changePlayer(
  diagram: DiagramShape,
  name: string,
  change: Partial<PlayerShape>,
): DiagramShape {
  const players = diagram.players.map((one) => (one.name === name ? { ...one, ...change } : one));
  return { ...diagram, players };
}

/** The diagram without a player and without all elements that involve the player. */
export function removePlayer(diagram: DiagramShape, name: string): DiagramShape {
  return {
    ...diagram,
    ball: diagram.ball === name ? "" : diagram.ball,
    players: diagram.players
      .filter((one) => one.name !== name)
      .map((one) => (one.guards === name ? { ...one, guards: "" } : one)),
    elements: diagram.elements.filter((one) => one.player !== name && one.other !== name),
  };
}

export function changeElement(
  diagram: DiagramShape,
  index: number,
  change: Partial<ElementShape>,
): DiagramShape {
  const elements = diagram.elements.map((one, i) => (i === index ? { ...one, ...change } : one));
  return { ...diagram, elements };
}

export function removeElement(diagram: DiagramShape, index: number): DiagramShape {
  return { ...diagram, elements: diagram.elements.filter((_, i) => i !== index) };
}

/** The step after the last element of a player, including passes to the player. */
export function nextStep(diagram: DiagramShape, player: string): number {
  const steps = diagram.elements
    .filter((one) => one.player === player || (one.kind === "pass" && one.other === player))
    .map((one) => Math.max(one.step, one.caught));
  return Math.max(0, ...steps) + 1;
}

/** The diagram with room for a new step before a step, and before all that comes after it. */
function makeRoom(diagram: DiagramShape, step: number): DiagramShape {
  const later = (value: number): number => (value >= step ? value + 1 : value);
  const elements = diagram.elements.map((one) => ({
    ...one,
    step: later(one.step),
    caught: one.caught && later(one.caught),
  }));
  return { ...diagram, elements };
}

/** The step after an element, and the diagram with room for it where its player is busy then. */
function stepAfter(diagram: DiagramShape, after: number): [DiagramShape, number] {
  const { player, step, caught } = diagram.elements[after]!;
  const next = Math.max(step, caught) + 1;
  const busy = diagram.elements.some((one) => {
    if (one.player === player) return one.step === next;
    return one.kind === "pass" && one.other === player && (one.caught || one.step) === next;
  });
  return [busy ? makeRoom(diagram, next) : diagram, next];
}

/**
 * Add an element. Its step follows the player's last one, or the element `target.after`: then what
 * comes later is moved by a step. By default, the other player is the one who stands nearest then.
 */
export function addElement(
  diagram: DiagramShape,
  kind: string,
  player: string,
  target: { to?: Spot; other?: string; after?: number | null },
): DiagramShape {
  if (target.after !== undefined && target.after !== null) {
    const [room, step] = stepAfter(diagram, target.after);
    return addAt(room, kind, player, target, step);
  }
  return addAt(diagram, kind, player, target, nextStep(diagram, player));
}

function addAt(
  diagram: DiagramShape,
  kind: string,
  player: string,
  target: { to?: Spot; other?: string },
  step: number,
): DiagramShape {
  const { team } = diagram.players.find((one) => one.name === player)!;
  let other = target.other ?? "";
  if (!other && needsOther(kind)) {
    const then = diagram.players
      .filter((one) => one.name !== player)
      .map((one) => ({ ...one, at: placeBefore(diagram, one.name, step) }));
    const wanted: Team = kind === "pass" ? team : team === "attack" ? "defence" : "attack";
    const from = target.to ?? placeBefore(diagram, player, step);
    other = nearest({ ...diagram, players: then }, from, wanted) ?? "";
  }
  const to = endsAtPlace(kind) && target.to ? onCourt(target.to, diagram) : null;
  const element: ElementShape = {
    kind: kind as ElementShape["kind"],
    step,
    caught: 0,
    player,
    other,
    via: [],
    to,
    line: null,
  };
  return { ...diagram, elements: [...diagram.elements, element] };
}

/** The position of a player before an element (its index), or at the end of the play. */
export function placeBefore(diagram: DiagramShape, name: string, step: number, index = -1): Spot {
  let place: Spot = diagram.players.find((one) => one.name === name)?.at ?? [0, 0];
  const earlier = diagram.elements
    .map((element, i) => ({ element, i }))
    .filter(({ element }) => element.player === name && element.to)
    .filter(({ element, i }) => element.step < step || (element.step === step && i < index))
    .sort((a, b) => a.element.step - b.element.step || a.i - b.i);
  for (const { element } of earlier) place = element.to!;
  return place;
}

/** Move the selection to a position. */
export function moveTo(diagram: DiagramShape, selection: Selection, place: Spot): DiagramShape {
  const at = onCourt(place, diagram);
  if (selection?.what === "player") return changePlayer(diagram, selection.name, { at });
  if (selection?.what === "place") {
    const places = diagram.places.map((one) => (one.name === selection.name ? { ...one, at } : one));
    return { ...diagram, places };
  }
  if (selection?.what !== "element" || selection.point === null) return diagram;
  const { index, point } = selection;
  const element = diagram.elements[index]!;
  if (point === "end") return changeElement(diagram, index, { to: at });
  return changeElement(diagram, index, { via: element.via.map((spot, i) => (i === point ? at : spot)) });
}

/** The position of the selected point; null for an element without one. */
export function placeOf(diagram: DiagramShape, selection: Selection): Spot | null {
  if (selection?.what === "player")
    return diagram.players.find((one) => one.name === selection.name)?.at ?? null;
  if (selection?.what === "place")
    return diagram.places.find((one) => one.name === selection.name)?.at ?? null;
  if (selection?.what !== "element" || selection.point === null) return null;
  const element = diagram.elements[selection.index];
  return (selection.point === "end" ? element?.to : element?.via[selection.point]) ?? null;
}
