/** Changes of a diagram; every function returns a new diagram. */

import type { DiagramShape, ElementShape, PlayerShape } from "../../api/types.ts";
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

/** The selection on the board: a player, or an element with one of its points. */
export type Selection =
  { what: "player"; name: string } | { what: "element"; index: number; point: "end" | number | null } | null;

/** A place rounded to centimetres and kept on the court. */
export function onCourt([x, z]: Spot, { court }: DiagramShape): Spot {
  const keep = (value: number, least: number, most: number): number =>
    Math.round(Math.min(Math.max(value, least), most) * 100) / 100;
  return [
    keep(x, -court.width / 2, court.width / 2),
    keep(z, -court.behind_rim, court.length - court.behind_rim),
  ];
}

export function emptyDiagram(): DiagramShape {
  return {
    title: "New play",
    grammar: "basketball",
    ball: "",
    court: { width: 15, length: 14, behind_rim: 1.575, lines: true },
    places: [{ name: "rim", at: [0, 0] }],
    players: [
      { name: "A1", team: "attack", at: [0, 8], guards: "" },
      { name: "A2", team: "attack", at: [-4.8, 5.6], guards: "" },
    ],
    elements: [],
  };
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

/** Add an element. By default, its step follows the player's last one, and the other player is the nearest opponent. */
export function addElement(
  diagram: DiagramShape,
  kind: string,
  player: string,
  target: { to?: Spot; other?: string },
): DiagramShape {
  const { at, team } = diagram.players.find((one) => one.name === player)!;
  let other = target.other ?? "";
  if (!other && needsOther(kind)) {
    const others = { ...diagram, players: diagram.players.filter((one) => one.name !== player) };
    const wanted: Team = kind === "pass" ? team : team === "attack" ? "defence" : "attack";
    other = nearest(others, target.to ?? at, wanted) ?? "";
  }
  const to = endsAtPlace(kind) && target.to ? onCourt(target.to, diagram) : null;
  const element: ElementShape = {
    kind: kind as ElementShape["kind"],
    step: nextStep(diagram, player),
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
  if (selection?.what !== "element" || selection.point === null) return null;
  const element = diagram.elements[selection.index];
  return (selection.point === "end" ? element?.to : element?.via[selection.point]) ?? null;
}
