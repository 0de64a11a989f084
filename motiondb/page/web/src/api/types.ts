/** Types of the server's answers. The contract is `GET /api/openapi.json`. Times in seconds. */

export interface Caption {
  words: string;
  /** null: the whole capture. */
  start: number | null;
  end: number | null;
}

export interface Segment {
  symbol: number;
  start: number;
  end: number;
  known: boolean;
}

export interface Source {
  capture: string;
  licence: string;
  sha256: string;
  frames: number;
}

export interface Stretch {
  start: number;
  end: number;
  capture: string | null;
  source_start: number | null;
  licence: string | null;
  edit: string;
}

export interface WordProbability {
  word: string;
  probability: number;
}

/** A word of a motion; without a probability where no own caption has checked it. */
export interface DescribedWord {
  word: string;
  probability: number | null;
}

export interface WordsOverTime {
  start: number;
  end: number;
  words: DescribedWord[];
  symbols?: number[];
}

export interface Status {
  version: string;
  database: string;
  read_only: boolean;
  learned: boolean;
  current: boolean;
  captures: number;
  generated: number;
  seconds: number;
  performers: number;
  captures_with_words: number;
  copies: number;
  grammars: number;
  symbols: number | null;
  clusters: number | null;
  words: number | null;
  not_yet_learned: number;
  bytes: number;
  revision: number;
  drift: { relearn: boolean; reasons: string[]; words: string[] };
  accepts: {
    captures: string[];
    /** Files that belong to captures: skeletons of ASF/AMC. */
    skeletons: string[];
    sheets: string[];
    max_file_bytes: number;
    max_request_bytes: number;
    max_files: number;
  };
  folders: { root: number; name: string }[];
  running_jobs: number;
}

export interface CaptureRow {
  name: string;
  ref: string;
  kind: string;
  format: string;
  fps: number;
  frames: number;
  duration: number;
  performer: string | null;
  licence: string | null;
  tags: Record<string, string>;
  words: Caption[];
  notes: string[];
  learned: boolean;
  copies: number;
}

export interface CapturePage {
  total: number;
  offset: number;
  revision: number;
  captures: CaptureRow[];
}

export interface Facet {
  column: string;
  label: string;
  values: { value: string; count: number; where: string }[];
  more: number;
}

export interface CopyRelation {
  capture: string;
  kind: string;
  other: string;
  start: number | null;
  end: number | null;
  distance?: number;
}

/** One capture: as a row, but with its copies listed. */
export interface CaptureFacts extends Omit<CaptureRow, "copies"> {
  copies: CopyRelation[];
  leg_length: number;
  path: string;
  sha256: string;
  events: { time: number; name: string; joint: string | null; other: string | null }[];
  segments: Segment[];
  activities: { activity: number; start: number; end: number; words: string[] }[];
  recognised: WordsOverTime[];
  sources: Source[];
  stretches: Stretch[];
  grammar: string | null;
  string: string[] | null;
  scene: string | null;
}

export interface WordsEdited {
  capture: string;
  words: Caption[];
  counted: boolean;
  new_words: string[];
  undo: number;
}

export interface DuplicateGroup {
  keep: string;
  captures: string[];
  relations: CopyRelation[];
}

export interface Upload {
  upload: string;
  files: { name: string; ref: string; bytes: number; kind: "capture" | "skeleton" | "sheet" }[];
  refused: { name: string; message: string }[];
}

export type JobState = "waiting" | "running" | "done" | "failed" | "cancelled";

export interface Job {
  id: string;
  kind: "add" | "learn" | "grammar" | "scene" | "scene-update";
  title: string;
  state: JobState;
  what: string;
  share: number;
  error: number | null;
  started: number | null;
  seconds: number;
  message: string | null;
  result: Record<string, unknown> | null;
  /** Ref of the first motion of a scene that is being updated. */
  preview: string | null;
  curve?: [number, number][];
}

export type QuestionTree =
  | { kind: "action"; words: string[]; sides: { side: string; limb: string }[]; manner: string[] }
  | { kind: "in_order" | "at_once" | "both" | "any_of"; parts: QuestionTree[] }
  | { kind: "without"; part: QuestionTree; excluded: QuestionTree[] }
  | { kind: "repeated"; part: QuestionTree; at_least: number | null; at_most: number | null }
  | { kind: "lasting"; part: QuestionTree; least_seconds: number | null; most_seconds: number | null }
  | { kind: "anything" };

export interface Question {
  text: string;
  understood: string;
  tree: QuestionTree | null;
  not_used: { text: string; reason: string }[];
}

export interface SymbolShare {
  symbol: number;
  from: number;
  to: number;
  share: number;
}

export interface ExplainedWord {
  word: string;
  log_odds: number;
  log_probability: number;
  contribution: number;
  prior: number;
  written: number;
  /** What the comparison of a quoted question with whole captions adds. */
  as_caption: number;
  symbols: SymbolShare[];
  /** The largest shares, where neighbours with the same symbol are one; `others` is the rest. */
  strongest: SymbolShare[];
  others: number;
}

export interface Explanation {
  log_odds: number;
  together: number;
  words: ExplainedWord[];
  excluded: { amount: number; log_odds: number; words: ExplainedWord[] }[];
}

export interface MatchPart {
  words: string;
  start: number | null;
  end: number | null;
  probability: number | null;
  interval_probability: number | null;
  place: "known" | "unknown";
}

export interface Match {
  rank: number;
  capture: string;
  ref: string;
  start: number;
  end: number;
  score: number;
  probability: number | null;
  interval_probability?: number | null;
  place?: "known" | "unknown";
  words: string[];
  reason?: string;
  duration: number;
  performer: string | null;
  licence: string | null;
  parts?: MatchPart[];
  explain?: Explanation | null;
  timeline?: { segments: Segment[]; words: Caption[] };
}

export interface Answer {
  matches_anything: boolean | null;
  strength: number | null;
  threshold: number | null;
  /** Why there are no probabilities; empty where there are. */
  unchecked: string;
  not_yet_learned: number;
  took: number;
  matches: Match[];
}

/** The symbols that words were decoded to, where a search by symbols was asked for. */
export interface Decoding {
  symbols: number[];
  log_probability: number;
  certificate: string;
}

export interface SearchAnswer extends Answer {
  question: Question;
  decoding: Decoding | null;
  taken: Record<string, WordProbability[]>;
  suggested: Record<string, WordProbability[]>;
  unknown: Record<string, string[]>;
  sentences: string[];
  /** Which captions taught the words, where the database learned with a start. */
  sources: string[];
}

export interface LikeAnswer extends Answer {
  ref: string;
  start: number | null;
  end: number | null;
}

export interface Made {
  id: string;
  ref: string;
  words: string;
  seed: number;
  method: string;
  seconds: number;
  actions: string[][];
  spans: { words: string; start: number; end: number }[];
  symbols: number[];
  recognised: number[];
  recognised_words: WordsOverTime[];
  shown: {
    text: string;
    start: number;
    end: number;
    probability: number | null;
    /** null: the judge cannot tell. */
    shown: boolean | null;
    reason: string | null;
  }[];
  not_shown: { text: string; reason: string }[];
  sources: Source[];
  stretches: Stretch[];
  saved: string | null;
}

export interface GenerateAnswer {
  question: Question;
  taken: Record<string, WordProbability[]>;
  suggested: Record<string, WordProbability[]>;
  unknown: Record<string, string[]>;
  sentences: string[];
  variants: Made[];
}

export interface SymbolFacts {
  symbol: number;
  at: number[];
  cluster: number;
  count: number;
  captures: number;
  seconds: number;
  words: WordProbability[];
}

export interface SymbolSpace {
  dimensions: number;
  stress: number[];
  symbols: SymbolFacts[];
  clusters: { cluster: number; weight: number; mean: number[]; covariance: number[][] }[];
}

export interface SymbolSegments {
  symbol: number;
  total: number;
  segments: { capture: string; ref: string; start: number; end: number; log_likelihood: number }[];
}

/** A part of something that can be played or downloaded. */
export interface Part {
  ref: string;
  start?: number | null;
  end?: number | null;
}
