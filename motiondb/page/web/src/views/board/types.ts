/** Tactics diagrams and scenes as the server sends them. Places are [x, z] in metres, the rim at [0, 0]. */

export type Spot = [x: number, z: number];
export type Team = "attack" | "defence" | "player";

export interface DiagramPlayer {
  name: string;
  team: Team;
  at: Spot;
  guards: string;
}

export interface DiagramElement {
  kind: string;
  step: number;
  /** The step at which a pass is caught; 0: that of the pass. */
  caught: number;
  player: string;
  other: string;
  via: Spot[];
  to: Spot | null;
}

export interface Court {
  width: number;
  length: number;
  behind_rim: number;
  lines: boolean;
}

export interface Diagram {
  title: string;
  grammar: string;
  ball: string;
  court: Court;
  places: { name: string; at: Spot }[];
  players: DiagramPlayer[];
  elements: DiagramElement[];
}

export interface Board {
  name: string;
  shipped: boolean;
  text: string;
  diagram: Diagram | null;
  feasible: boolean;
  fault: string | null;
  line: number | null;
  faults: { line: number | null; message: string; player: string | null }[];
  holder: string | null;
  elements: { element: number; feasible: boolean; reason: string | null }[];
  players: { name: string; shortest: string[]; expression: string; reason: string | null }[];
  clips: Record<string, number>;
  without_clips: string[];
}

export interface BoardKinds {
  kinds: string[];
  teams: Team[];
  grammars: string[];
}

export interface Rule {
  player: string;
  action: string;
  rule: string;
  about: string;
  unit: string;
  before: number | null;
  after: number | null;
  threshold: number | null;
  frame: number | null;
  start: number | null;
  end: number | null;
  frames: number | null;
  kept: boolean;
}

/** Motion that no person can do. */
export interface Impossible {
  players: string[];
  action: string;
  kind: string;
  start: number;
  end: number;
  frame: number;
}

export interface SceneFacts {
  ref: string;
  text: string;
  report: { by_rule: Rule[]; impossible?: Impossible[] } & Record<string, unknown>;
  curve: [number, number][];
}
