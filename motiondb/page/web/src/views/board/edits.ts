/** Changes of a diagram; every function returns a new diagram. */

import type { DiagramShape, ElementShape, Ground, PlayerShape } from "../../api/types.ts";
import type { Spot, Team } from "./spot.ts";
import { endsAtPlace, groundNow, linkOf, lookOf, needsOther, verbOf } from "./verbs.ts";

/** The selection on the board: a player, a place, or an element with one of its points. */
export type Selection =
  | { what: "player"; name: string }
  | { what: "place"; name: string }
  | { what: "element"; index: number; point: "end" | number | null }
  | null;

/** A place rounded to centimetres and kept on the ground. */
export function onCourt([x, z]: Spot, { ground }: DiagramShape): Spot {
  const keep = (value: number, least: number, most: number): number =>
    Math.round(Math.min(Math.max(value, least), most) * 100) / 100;
  return [
    keep(x, ground.left, ground.left + ground.width),
    keep(z, ground.back, ground.back + ground.length),
  ];
}

/** Where the first players of a new diagram stand, as shares of the ground. */
const FIRST: readonly Spot[] = [
  [0.5, 0.684],
  [0.18, 0.5125],
];

/** A new diagram: two players of the first role or one person, and the places that the grammar names. */
export function emptyDiagram(ground: Ground = groundNow()): DiagramShape {
  const { left, back, width, length } = ground.ground;
  const at = ([x, z]: Spot): Spot =>
    [left + x * width, back + z * length].map((one) => Math.round(one * 10) / 10) as Spot;
  const team = ground.teams[0] ?? "player";
  const apart = 1 / (ground.places.length + 1);
  return {
    title: `New ${ground.grammar || "play"}`,
    grammar: ground.grammar || "basketball",
    ball: "",
    ground: ground.ground,
    places: ground.places.map((name, i) => ({
      name,
      at: at([apart * (i + 1), 0.5]),
      given: false,
      height: 0,
      width: 0,
      tall: 0,
    })),
    players: FIRST.slice(0, team === "player" ? 1 : 2).map((spot, i) => ({
      name: `${prefix(team)}${i + 1}`,
      team,
      at: at(spot),
      guards: "",
    })),
    elements: [],
    more: [],
  };
}

/** A diagram without players: that of a text that cannot be read. */
export function blankDiagram(): DiagramShape {
  return { ...emptyDiagram(), title: "", players: [] };
}

const prefix = (team: Team): string => team.slice(0, 1).toUpperCase();

export function addPlayer(diagram: DiagramShape, team: Team, at: Spot): [DiagramShape, string] {
  const taken = new Set(diagram.players.map((one) => one.name));
  let number = 1;
  while (taken.has(`${prefix(team)}${number}`)) number += 1;
  const name = `${prefix(team)}${number}`;
  const player: PlayerShape = { name, team, at: onCourt(at, diagram), guards: "" };
  const [first, second] = groundNow().teams;
  if (team === second && team !== "player") player.guards = nearest(diagram, at, first!) ?? "";
  return [{ ...diagram, players: [...diagram.players, player] }, name];
}

/** The name of the player, perhaps of a role, who stands nearest to a place at the beginning. */
export function nearest(diagram: DiagramShape, [x, z]: Spot, team?: Team): string | null {
  const apart = (one: PlayerShape): number => Math.hypot(one.at[0] - x, one.at[1] - z);
  const members = diagram.players.filter((one) => !team || one.team === team);
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
    .filter((one) => one.player === player || (lookOf(one.kind) === "give" && one.other === player))
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
    return lookOf(one.kind) === "give" && one.other === player && (one.caught || one.step) === next;
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
    const from = target.to ?? placeBefore(diagram, player, step);
    const { role } = verbOf(kind)!;
    const fits = then.filter((one) => {
      if (role === "receiver") return one.team === team;
      return role !== "opponent" || one.team !== team || team === "player";
    });
    other = nearest({ ...diagram, players: fits }, from) ?? "";
  }
  const to = endsAtPlace(kind) && target.to ? onCourt(target.to, diagram) : null;
  const element: ElementShape = {
    kind,
    step,
    caught: 0,
    player,
    other,
    via: [],
    to,
    line: null,
    target: "",
    link: other ? linkOf(kind) : "",
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
    const places = diagram.places.map((one) =>
      one.name === selection.name ? { ...one, at, given: false } : one,
    );
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
