/** Types of requests and replies, written by ../../typescript.py. Times in seconds. */

export interface Accepted {
  captures: string[];
  skeletons: string[];
  sheets: string[];
  max_file_bytes: number;
  max_request_bytes: number;
  max_files: number;
}

export interface AcceptedFile {
  name: string;
  ref: string;
  bytes: number;
  kind: string;
}

export interface ActionTree {
  kind: "action";
  words: string[];
  sides: SideOfAction[];
  manner: string[];
}

export interface ActionVerdict {
  words: string[];
  start: number;
  end: number;
  shown: boolean | null;
  probability: number | null;
  reason: string;
  described: WordProbability[];
  done: string[];
}

export interface AddBody {
  sample?: boolean;
  upload?: string | null;
  folder?: FolderBody | null;
  words?: string | null;
  unit?: string | null;
  fps?: number | null;
  up?: string;
  mirror_world?: boolean;
  swap_sides?: boolean;
  keep_implausible?: boolean;
  skip_bad_frames?: boolean;
}

export interface AddResult {
  kind: "add";
  added: number;
  known: number;
  captures: string[];
  problems: string[];
  notes: string[];
  new_words: string[];
  counted: number;
  seconds: number;
}

export interface AllowedFolder {
  root: number;
  name: string;
}

export interface AlternativesBody {
  id: string;
  at: number;
  wider?: number;
  narrower?: number;
  number?: number;
  seed?: number;
}

export interface AlternativesReply {
  region: Region;
  can_widen: boolean;
  can_narrow: boolean;
  alternatives: (PlayableAlternative | Unplayable)[];
}

export interface AnswerBody {
  grammar: string;
  run: number;
  first: string;
  then: string;
  said: "yes" | "no" | "unknown";
  author: string;
}

export interface AnswerReply {
  said: "yes" | "no" | "unknown";
  obeyed: boolean;
}

export interface AnythingTree {
  kind: "anything";
}

export interface BlockBody {
  phrase: string;
  seconds?: number | null;
  place?: number | null;
  capture?: string | null;
  start?: number | null;
  end?: number | null;
}

export interface BoardBody {
  text?: string | null;
  diagram?: DiagramShape | null;
}

export interface BoardFault {
  line: number;
  message: string;
  player: string;
  code: string;
  fields: Record<string, string>;
}

export interface BoardFile {
  name: string;
  title: string;
  shipped: boolean;
}

export interface BoardKinds {
  grammars: string[];
  grounds: Ground[];
}

export interface BoardReply {
  name: string;
  shipped: boolean;
  text: string;
  diagram: DiagramShape | null;
  feasible: boolean;
  fault: string | null;
  line: number | null;
  faults: BoardFault[];
  holder: string | null;
  elements: ElementVerdict[];
  players: PlayerVerdict[];
  clips: Record<string, number>;
  without_clips: string[];
}

export interface BoardVerb {
  name: string;
  link: string;
  role: string;
  goes: boolean;
  look: string;
  holding: string;
  bar: boolean;
  declared: boolean;
}

export interface BoardsReply {
  boards: BoardFile[];
}

export interface Box {
  centre: [number, number, number];
  size: [number, number, number];
}

export interface Caption {
  words: string;
  start: number | null;
  end: number | null;
}

export interface CaptionBody {
  words: string;
  start?: number | null;
  end?: number | null;
}

export interface CaptionsBody {
  capture: string;
  words: CaptionBody[];
  before?: CaptionBody[] | null;
}

export interface CaptureDetails {
  capture_id: number;
  name: string;
  sha256: string;
  format: string;
  kind: string;
  fps: number;
  n_frames: number;
  duration: number;
  motion_frames: number;
  leg_length: number;
  path: string;
  run_id: number;
  tags: Record<string, string>;
  notes: string[];
  words: Caption[];
  ref: string;
  learned: boolean;
  copies: number;
  relations: Relation[];
  events: ShownEvent[];
  segments: WordedSegment[];
  activities: ShownActivity[];
  lacks: Finding[];
  ghosts: Ghost[];
  recognised: WordsOverTime[];
  sources: Source[];
  stretches: Stretch[];
  grammar: string | null;
  string: string[] | null;
}

export interface CapturePage {
  total: number;
  offset: number;
  revision: number;
  captures: CaptureRow[];
  found: number | null;
}

export interface CaptureRow {
  ref: string;
  name: string;
  kind: string;
  duration: number;
  tags: Record<string, string>;
  notes: string[];
  words: Caption[];
  learned: boolean;
  copies: number;
}

export interface CaptureTagsBody {
  captures: string[];
  tags: Record<string, string>;
}

export interface CaptureWordsBody {
  captures: string[];
  words: string;
}

export interface CapturesBody {
  captures: string[];
}

export interface CapturesChanged {
  changed: string[];
  undo: number;
}

export interface ChoiceReply {
  choice: SplitChoice;
  symbols: number[];
  left_out: Record<string, number>;
}

export interface Collision {
  players: [string, string];
  start: number;
  end: number;
  depth: number;
}

export interface CompareReply {
  grammars: ComparedGrammar[];
}

export interface ComparedGrammar {
  kind: string;
  nonterminals: number;
  rules: number;
  bits: number;
  strings: number | null;
  held_out: number | null;
  new: number;
  outside: number;
  mean_length: number;
  foresight: Foresight | null;
}

export interface DecodedAction {
  symbols: number[];
  log_probability: number;
  nodes_expanded: number;
  certificate: string;
}

export interface Decoding {
  symbols: number[];
  log_probability: number;
  nodes_expanded: number;
  certificate: string;
  bound: number;
}

export interface DescribeReply {
  ref: string;
  duration: number;
  words: WordsOverTime[];
}

export interface DescribedWord {
  word: string;
  probability: number | null;
}

export interface DiagramShape {
  title: string;
  players: PlayerShape[];
  grammar: string;
  ball: string;
  ground: GroundShape;
  places: PlaceShape[];
  elements: ElementShape[];
  more: string[];
}

export interface DoubtfulSentence {
  shown: Medoid;
  string: string[];
  instead: string[];
  says: string;
}

export interface DownloadBody {
  items: Part[];
  format?: "bvh" | "glb" | "fbx" | "usd" | "npz" | "csv" | "parquet" | "source";
  canonical?: boolean;
  alone?: boolean;
  fps?: number | null;
  onto?: string | null;
}

export interface Drift {
  captures_added: number;
  captures_removed: number;
  seconds_added: number;
  explained_less: number;
  strange: number;
  below_background: number;
  strange_of_all: number;
  new_words: number;
  turnover: number;
  words: string[];
  relearn: boolean;
  reasons: string[];
}

export interface DuplicateGroup {
  captures: string[];
  relations: Relation[];
}

export interface DuplicatesReply {
  groups: DuplicateGroup[];
}

export interface EditBody {
  grammar: string;
  run: number;
}

export interface ElementShape {
  kind: string;
  step: number;
  player: string;
  other: string;
  caught: number;
  via: [number, number][];
  to: [number, number] | null;
  line: number | null;
  target: string;
  link: string;
}

export interface ElementVerdict {
  element: number;
  feasible: boolean;
  reason: string | null;
}

export interface ErrorFacts {
  kind: string;
  message: string;
  status: number;
}

export interface ErrorReply {
  error: ErrorFacts;
}

export interface ExamplesReply {
  examples: ProvenQuestion[];
  words: string[];
}

export interface ExplainedExclusion {
  amount: number;
  log_odds: number;
  words: ExplainedWord[];
}

export interface ExplainedWord {
  word: string;
  log_odds: number;
  log_probability: number;
  contribution: number;
  prior: number;
  written: number;
  likeness: number;
  symbols: SymbolShare[];
  strongest: SymbolShare[];
  others: number;
}

export interface Explanation {
  log_odds: number;
  together: number;
  words: ExplainedWord[];
  excluded: ExplainedExclusion[];
  suggests: string[];
}

export interface FacetRow {
  column: string;
  values: FacetValue[];
  more: number;
  missing: number;
}

export interface FacetValue {
  value: string;
  count: number;
  where: string;
}

export interface FacetsReply {
  total: number;
  facets: FacetRow[];
}

export interface Finding {
  kind: string;
  family: string;
  start: number;
  end: number;
  measure: number;
  unit: string;
  threshold: number;
  part: string;
  sentence: string;
  place: [number, number, number] | null;
  boxes: Box[];
}

export interface FolderBody {
  root: number;
  path?: string;
}

export interface FolderReply {
  root: number;
  path: string;
  folders: string[];
  captures: number;
  sheets: string[];
}

export interface Foresight {
  windows: number;
  foreseen: number;
  right_of_two: number;
  accepted: number;
  freedom: number;
  weight: number;
  extreme: string;
}

export interface GenerateBody {
  words?: string;
  blocks?: BlockBody[];
  seed?: number;
  variants?: number;
  method?: "stitched" | "trajectory";
  exact?: boolean;
}

export interface GenerateReply {
  question: UnderstoodQuestion;
  taken: Record<string, WordProbability[]>;
  suggested: Record<string, WordProbability[]>;
  unknown: Record<string, string[]>;
  missing: string[];
  sentences: string[];
  variants: MadeReply[];
}

export interface Ghost {
  sentence: string;
  start: number;
  end: number;
  centre: [number, number, number];
  size: [number, number, number];
}

export interface GrammarEdited {
  grammar: string;
  no_longer_editable: string[];
  undone: string | null;
}

export interface GrammarLearned {
  kind: "grammar";
  grammar: string;
  no_longer_editable: string[];
}

export interface GrammarQuestion {
  first: string;
  then: string;
  observed: number;
  gain: number;
  first_shown: Medoid;
  then_shown: Medoid;
  first_words: string;
  then_words: string;
}

export interface GrammarReply {
  grammar: string;
  run: number;
  seed: number | null;
  settings: Record<string, unknown>;
  captures: LearnedTake[];
  frames: number;
  segments: number;
  terminals: TerminalRow[];
  objective: number | null;
  sentences: number;
  sentence_lengths: [number, number, number];
  nonterminals: number;
  rules: number;
  derives_new: boolean;
  doubtful: DoubtfulSentence[];
  left_out: Medoid[];
  foresight: Foresight | null;
  foresight_says: string;
  bits: Record<string, number>;
  text: string;
  text_with_loops: string;
  sequences: string[];
  edits: string[];
}

export interface GrammarsReply {
  grammars: ListedGrammar[];
}

export interface Ground {
  grammar: string;
  verbs: BoardVerb[];
  teams: string[];
  places: string[];
  object: string;
  ground: GroundShape;
}

export interface GroundShape {
  width: number;
  length: number;
  left: number;
  back: number;
  own: boolean;
  marks: [number, number, number][][];
}

export interface GuardReport {
  player: string;
  target: string;
  near: number;
  far: number | null;
  n_frames: number;
  outside: number;
  farthest: number;
  frame: number;
}

export interface ImpossibleMotion {
  kind: string;
  players: string[];
  action: string;
  start: number;
  end: number;
  frame: number;
  value: number;
  limit: number;
  unit: string;
}

export interface JobReply {
  what: string;
  share: number;
  whole: number | null;
  left: number | null;
  error: number | null;
  preview: string | null;
  id: string;
  kind: string;
  title: string;
  state: "waiting" | "running" | "done" | "failed" | "cancelled";
  started: number;
  seconds: number;
  message: string | null;
  error_kind: string | null;
  result: AddResult | LearnResult | GrammarLearned | SceneMade | null;
  curve: [number, number][];
}

export interface JobsReply {
  jobs: JobReply[];
}

export interface JoinedTree {
  kind: "in_order" | "at_once" | "both" | "any_of";
  parts: (ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree)[];
}

export interface JointProposal {
  file: string;
  joints: number;
  is_known: boolean;
  roles: Record<string, string>;
  missing: string[];
  map: string | null;
}

export interface JumpReport {
  player: string;
  foot: string;
  metres: number;
  start: number;
  end: number;
  source_metres: number;
}

export interface KeepBody {
  ref: string;
  name: string;
}

export interface LastingTree {
  kind: "lasting";
  part: ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree;
  least_seconds: number | null;
  most_seconds: number | null;
}

export interface LearnBody {
  captures: string[];
  name?: string | null;
  terminals?: number | null;
  sentences?: "auto" | "captures" | "captions";
  from_symbols?: boolean;
  shortest?: number;
  longest?: number;
  seed?: number;
}

export interface LearnResult {
  captures: number;
  segments: number;
  symbols: number;
  clusters: number;
  dimensions: number;
  words: number;
  run: number;
  kind: "learn";
  start: string | null;
}

export interface LearnedTake {
  capture: string;
  sha256: string;
  seconds: number;
  there: boolean;
}

export interface LearningBody {
  symbols?: number | null;
  seed?: number;
  start?: string | null;
}

export interface LikeReply {
  matches_anything: boolean | null;
  strength: number | null;
  threshold: number | null;
  unchecked: string;
  matches: ShownMatch[];
  read_as: string;
  ref: string;
  start: number | null;
  end: number | null;
  not_yet_learned: number;
  took: number | null;
}

export interface LimbReport {
  players: [string, string];
  metres: number;
  frame: number;
  n_frames: number;
}

export interface ListedGrammar {
  grammar: string;
  run: number;
  captures: number;
  frames: number;
  terminals: number;
  segments: number;
  sentences: number;
  nonterminals: number;
  rules: number;
  bits: Record<string, number>;
  seconds: number;
  derives_new: boolean;
}

export interface ListedScene {
  scene: string;
  characters: number;
  clips: number;
  frames: number;
  seconds: number;
  error: number;
  rules: number;
  broken: number;
  ref: string;
}

export interface MadeReply {
  words: string;
  seed: number;
  method: string;
  seconds: number;
  shown: boolean;
  why_not: string;
  actions: string[][];
  shown_actions: ActionVerdict[];
  decided: string[];
  symbols: number[];
  recognised: number[];
  decodings: DecodedAction[];
  sources: Source[];
  smoothness: Smoothness;
  words_from: WordSource[];
  question: UnderstoodQuestion;
  id: string;
  ref: string;
  recognised_words: WordsOverTime[];
  stretches: Stretch[];
  blocks: ShownBlock[];
  saved: string | null;
}

export interface MatchPart {
  words: string;
  start: number;
  end: number;
  probability: number | null;
  interval_probability: number | null;
  place: string;
}

export interface MeasuredRule {
  player: string;
  action: string;
  clip: number;
  rule: string;
  about: string;
  unit: string;
  before: number | null;
  after: number | null;
  threshold: number | null;
  frame: number;
  start: number;
  end: number;
  frames: number;
  kept: boolean;
}

export interface MeasuredTree {
  kind: "measured";
  part: ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree;
  what: string;
  at_least: number;
  at_most: number | null;
  said: string;
}

export interface Medoid {
  capture: string;
  start: number;
  end: number;
}

export interface MotionsBody {
  items: Part[];
  fps?: number;
}

export interface NamedBoardBody {
  text?: string | null;
  diagram?: DiagramShape | null;
  name: string;
}

export interface NextTerminal {
  terminal: string | null;
  end: boolean;
  probability: number;
}

export interface NotUsed {
  text: string;
  reason: string;
}

export interface OpenBody {
  capture: string;
}

export interface PaceReport {
  player: string;
  before: number;
  after: number;
}

export interface ParseAnswer {
  string: string[];
  spans: [number, number][];
  learned_from: boolean;
  distances: number[];
  usual_distance: number | null;
  unlike: number[];
  share_unlike: number;
  is_unlike: boolean;
  log_probability: number | null;
  order_rank: number | null;
  of_another_activity: string;
  sentences: ParsedSentence[];
  fault: ParseFault | null;
}

export interface ParseBody {
  grammar: string;
  capture: string;
}

export interface ParseFault {
  position: number;
  found: string | null;
  expected: string[];
  may_end: boolean;
  says: string;
}

export interface ParsedSentence {
  string: string[];
  tree: string;
}

export interface Part {
  ref: string;
  start?: number | null;
  end?: number | null;
}

export interface PlaceShape {
  name: string;
  at: [number, number];
  given: boolean;
  height: number;
  width: number;
  tall: number;
}

export interface PlacedSymbol {
  symbol: number;
  cluster: number;
  count: number;
  captures: number;
  seconds: number;
  words: WordProbability[];
  at: number[];
  typical: PlayableSegment | null;
}

export interface PlayableAlternative {
  grammar: string;
  seed: number;
  string: string[];
  tree: string;
  sentences: number;
  new_sentences: number;
  changes: number;
  longest_stretch: number;
  says: string;
  seconds: number;
  join_cost: number;
  foot_slip: number;
  foot_slip_of_sources: number;
  spans: TerminalSpan[];
  sources: Source[];
  id: string;
  ref: string;
  parent: string | null;
  edited: Positions | null;
  saved: string | null;
  strip: WordedTerminal[];
  path: RootPath;
  nodes: TreeNode[];
  stretches: Stretch[];
  region: string[];
  log_probability: number;
}

export interface PlayablePart {
  interval: number;
  capture: string;
  start: number;
  end: number;
  whole: boolean;
  kind: string;
  performer: string;
  licence: string;
  source: string;
  sha256: string;
  made_of: string[];
  file: string;
  ref: string;
}

export interface PlayableSegment {
  symbol: number;
  start: number;
  end: number;
  log_likelihood: number | null;
  known: boolean;
  capture: string;
  ref: string;
}

export interface PlayerShape {
  name: string;
  team: string;
  at: [number, number];
  guards: string;
}

export interface PlayerVerdict {
  name: string;
  shortest: string[];
  expression: string;
  reason: string | null;
}

export interface Positions {
  start: number;
  end: number;
}

export interface ProvenQuestion {
  question: string;
  capture: string;
  probability: number;
}

export interface QuestionsReply {
  questions: GrammarQuestion[];
}

export interface RefusedFile {
  name: string;
  message: string;
}

export interface Region {
  path: number[];
  symbol: string;
  start: number;
  end: number;
  position: number;
}

export interface Relation {
  capture: string;
  other: string;
  kind: string;
  start: number;
  end: number;
  distance: number;
}

export interface Removed {
  removed: string | string[];
  captures: string[] | null;
  no_longer_editable: string[] | null;
}

export interface RenameBody {
  old: string;
  new: string;
  captures?: string[] | null;
}

export interface RepeatedTree {
  kind: "repeated";
  part: ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree;
  at_least: number | null;
  at_most: number | null;
}

export interface RootPath {
  fps: number;
  points: [number, number][];
}

export interface RulesBody {
  grammar: string;
  run: number;
  text: string;
}

export interface SaveBody {
  id: string;
  name: string;
}

export interface Saved {
  capture: string;
  ref: string;
}

export interface SceneAnswer {
  scene: string;
  characters: number;
  clips: number;
  frames: number;
  seconds: number;
  error: number;
  rules: number;
  broken: number;
  collisions: Collision[];
  collisions_before: number;
  feet: Record<string, [number, number]>;
  paces: PaceReport[];
  impossible: ImpossibleMotion[];
  planted_feet: JumpReport[];
  near_limbs: LimbReport[];
  guards: GuardReport[];
  seen: SeenFault[];
  bone_error: number;
  ball_gap: number | null;
  too_fast: string[];
  settled: boolean;
  tries: number;
  cut_short: boolean;
  cut_at: Record<string, number> | null;
  sources: Source[];
  settings: Record<string, unknown>;
  ball: boolean;
  actions: Record<string, string[]>;
  by_rule: MeasuredRule[];
}

export interface SceneBody {
  text?: string | null;
  diagram?: DiagramShape | null;
  board?: string | null;
  seed?: number;
  rounds?: number;
  minutes?: number | null;
  chains?: number;
  gaze?: boolean;
}

export interface SceneKept {
  ref: string;
}

export interface SceneMade {
  kind: "scene";
  scene: string;
  ref: string;
}

export interface SceneReply {
  ref: string;
  name: string;
  text: string;
  board: DiagramShape;
  report: SceneAnswer;
  actions: Record<string, Caption[]>;
  curve: [number, number][];
  took: Record<string, number>;
}

export interface ScenesReply {
  scenes: ListedScene[];
}

export interface SearchReply {
  matches_anything: boolean | null;
  strength: number | null;
  threshold: number | null;
  unchecked: string;
  matches: ShownMatch[];
  read_as: string;
  question: UnderstoodQuestion;
  taken: Record<string, WordProbability[]>;
  suggested: Record<string, WordProbability[]>;
  unknown: Record<string, string[]>;
  missing: string[];
  sentences: string[];
  decoding: Decoding | null;
  sources: WordSource[];
  written: WrittenAnswer[];
  by_meaning: Record<string, string[]>;
  measured: string[];
  not_yet_learned: number;
  took: number | null;
}

export interface SeenFault {
  kind: string;
  players: string[];
  start: number;
  end: number;
  value: number;
  unit: string;
}

export interface SegmentsReply {
  symbol: number;
  total: number;
  segments: PlayableSegment[];
}

export interface SelectionBody {
  name: string;
  items: Part[];
}

export interface SelectionReply {
  selection: string;
  parts: PlayablePart[];
}

export interface SelectionRow {
  selection: string;
  captures: number;
  parts: number;
  seconds: number;
}

export interface SelectionsReply {
  selections: SelectionRow[];
}

export interface SequenceBody {
  grammar: string;
  seed?: number;
  length?: number | null;
  like?: string | null;
}

export interface SequenceReply {
  grammar: string;
  seed: number;
  string: string[];
  tree: string;
  sentences: number;
  new_sentences: number;
  changes: number;
  longest_stretch: number;
  says: string;
  seconds: number;
  join_cost: number;
  foot_slip: number;
  foot_slip_of_sources: number;
  spans: TerminalSpan[];
  sources: Source[];
  id: string;
  ref: string;
  parent: string | null;
  edited: Positions | null;
  saved: string | null;
  strip: WordedTerminal[];
  path: RootPath;
  nodes: TreeNode[];
  stretches: Stretch[];
}

export interface ShippedStart {
  name: string;
  words: number;
  captions: number;
  credit: string;
}

export interface ShownActivity {
  activity: number;
  start: number;
  end: number;
  words: string[];
}

export interface ShownBlock {
  phrase: string;
  seconds: number | null;
  place: number | null;
  capture: string | null;
  start: number | null;
  end: number | null;
  places: number;
}

export interface ShownEvent {
  frame: number;
  name: string;
  joint: string;
  other: string;
  seconds: number;
}

export interface ShownMatch {
  rank: number;
  capture: string;
  start: number;
  end: number;
  score: number;
  words: string[];
  reason: string;
  probability: number | null;
  interval_probability: number | null;
  place: string;
  parts: MatchPart[];
  in_order: boolean | null;
  contradicted: string[];
  explain: Explanation | null;
  ref: string;
  duration: number;
  performer: string | null;
  licence: string | null;
  kind: string;
  timeline: Timeline;
  poster: string | null;
}

export interface SideOfAction {
  side: string;
  limb: string;
}

export interface Smoothness {
  foot_slip: number | null;
  foot_slip_of_sources: number | null;
  toe_slip: number | null;
  toe_slip_of_sources: number | null;
  speed_jump: number;
  speed_jump_of_sources: number | null;
  floating: number | null;
  floating_of_sources: number | null;
}

export interface Source {
  capture: string;
  licence: string;
  sha256: string;
  frames: number;
}

export interface SpaceReply {
  dimensions: number;
  stress: number[];
  symbols: PlacedSymbol[];
  clusters: SymbolCluster[];
}

export interface SplitChoice {
  split: string;
  performers: string[];
  seconds: number;
  chosen: number;
  intervals: number;
  distance: number;
  bound: number;
}

export interface StartAnswer {
  name: string;
  version: string;
  captures: number;
  captions: number;
  performers: number;
  seconds: number;
  licences: Record<string, number>;
  runs: Record<string, unknown>[];
  credit: string;
  sha256: string;
  symbols: number;
  words: number;
  weight: number;
  own_captions: number;
  unchecked: string;
  strange_motion: number;
  fits: boolean;
  words_of_start_alone: number;
  words_of_both: number;
  words_of_own_captions_alone: number;
}

export interface Status {
  database: string;
  bytes: number;
  captures: number;
  generated: number;
  seconds: number;
  performers: number;
  captures_with_words: number;
  copies: number;
  grammars: number;
  learned: boolean;
  cache_bytes: number;
  parquet_bytes: number | null;
  motions_at: string[] | null;
  unused_bytes: number;
  removed: number;
  compact_pays: boolean;
  faulty_files: number;
  symbols: number | null;
  clusters: number | null;
  words: number | null;
  current: boolean | null;
  not_yet_learned: number | null;
  start: StartAnswer | null;
  version: string;
  read_only: boolean;
  revision: number;
  drift: Drift | null;
  accepts: Accepted;
  writes: string[];
  folders: AllowedFolder[];
  starts: ShippedStart[];
  running_jobs: number;
}

export interface Stretch {
  start: number;
  end: number;
  capture: string;
  source_start: number;
  licence: string;
  edits: string[];
}

export interface SuggestReply {
  next: NextTerminal[];
}

export interface SymbolCluster {
  cluster: number;
  weight: number;
  mean: number[];
  covariance: number[][];
}

export interface SymbolProbability {
  symbol: number;
  probability: number;
}

export interface SymbolShare {
  symbol: number;
  from: number;
  to: number;
  share: number;
}

export interface TerminalBody {
  grammar: string;
  run: number;
  terminal: string;
  to: string;
}

export interface TerminalRow {
  terminal: string;
  count: number;
  seconds: number;
  words: DescribedWord[];
  symbols: TerminalSymbol[];
  medoid: Medoid;
}

export interface TerminalSpan {
  terminal: string;
  start: number;
  end: number;
}

export interface TerminalSymbol {
  symbol: number;
  share: number;
}

export interface Timeline {
  segments: WordedSegment[];
  words: Caption[];
}

export interface TreeNode {
  symbol: string;
  parent: number;
  start: number;
  end: number;
  is_terminal: boolean;
}

export interface UnderstoodQuestion {
  text: string;
  understood: string;
  tree: ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree;
  not_used: NotUsed[];
}

export interface UndoState {
  left: number;
  capture: string | null;
}

export interface Unplayable {
  string: string[];
  region: string[];
  log_probability: number;
  not_playable: string;
}

export interface UpdateBody {
  text?: string | null;
  diagram?: DiagramShape | null;
  scene: string;
  seed?: number | null;
  minutes?: number | null;
}

export interface UploadReply {
  upload: string;
  files: AcceptedFile[];
  refused: RefusedFile[];
}

export interface VocabularyReply {
  words: WordRow[];
}

export interface WallReply {
  tiles: WallTile[];
}

export interface WallTile {
  capture: string;
  words: string;
  start: number;
  end: number;
  duration: number;
}

export interface WithoutTree {
  kind: "without";
  part: ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree;
  excluded: (ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree)[];
}

export interface WordProbability {
  word: string;
  probability: number;
}

export interface WordRow {
  word: string;
  count: number;
  symbols: SymbolProbability[];
}

export interface WordSource {
  word: string;
  start: string;
  start_captions: number;
  own_captions: number;
  weight: number;
}

export interface WordedSegment {
  symbol: number;
  start: number;
  end: number;
  log_likelihood: number | null;
  known: boolean;
  word: string | null;
  word_probability: number | null;
}

export interface WordedTerminal {
  terminal: string;
  nonterminal: string;
  start: number;
  end: number;
  capture: string;
  source_start: number;
  source_end: number;
  words: string[];
  at: number;
}

export interface WordsBody {
  words: string;
  start?: number | null;
  end?: number | null;
  capture: string;
  keep?: boolean | null;
}

export interface WordsEdited {
  capture: string;
  words: Caption[];
  counted: boolean;
  new_words: string[];
  undo: number;
}

export interface WordsOverTime {
  start: number;
  end: number;
  words: DescribedWord[];
  symbols: number[];
}

export interface WordsUndone {
  capture: string;
  words: Caption[];
  left: number;
  what: string;
  captures: number;
}

export interface WrittenAnswer {
  word: string;
  tags: string[];
  captures: number;
  in_captions: number;
}

export interface Got {
  "/api/along": LikeReply;
  "/api/board": BoardReply;
  "/api/board/kinds": BoardKinds;
  "/api/boards": BoardsReply;
  "/api/capture": CaptureDetails;
  "/api/captures": CapturePage;
  "/api/choice": ChoiceReply;
  "/api/describe": DescribeReply;
  "/api/duplicates": DuplicatesReply;
  "/api/examples": ExamplesReply;
  "/api/facets": FacetsReply;
  "/api/folders": FolderReply;
  "/api/grammar": GrammarReply;
  "/api/grammar/compare": CompareReply;
  "/api/grammar/questions": QuestionsReply;
  "/api/grammar/suggest": SuggestReply;
  "/api/grammars": GrammarsReply;
  "/api/jobs": JobsReply;
  "/api/jobs/{job_id}": JobReply;
  "/api/joints": JointProposal;
  "/api/like": LikeReply;
  "/api/made": GenerateReply;
  "/api/rhythm": LikeReply;
  "/api/scene": SceneReply;
  "/api/scenes": ScenesReply;
  "/api/search": SearchReply;
  "/api/selection": SelectionReply;
  "/api/selections": SelectionsReply;
  "/api/sequence": SequenceReply;
  "/api/status": Status;
  "/api/symbol": SegmentsReply;
  "/api/symbols": SpaceReply;
  "/api/undo": UndoState;
  "/api/vocabulary": VocabularyReply;
  "/api/wall": WallReply;
}

export interface Posted {
  "/api/add": JobReply;
  "/api/board/check": BoardReply;
  "/api/captures/remove": CapturesChanged;
  "/api/captures/rename": CapturesChanged;
  "/api/captures/tags": CapturesChanged;
  "/api/captures/words": CapturesChanged;
  "/api/generate": GenerateReply;
  "/api/grammar/answers": AnswerReply;
  "/api/grammar/parse": ParseAnswer;
  "/api/grammar/undo": GrammarEdited;
  "/api/grammars": JobReply;
  "/api/learn": JobReply;
  "/api/made/save": Saved;
  "/api/scenes": JobReply;
  "/api/scenes/keep": SceneKept;
  "/api/scenes/update": JobReply;
  "/api/selection/add": CapturesChanged;
  "/api/selection/take": CapturesChanged;
  "/api/sequences": SequenceReply;
  "/api/sequences/alternatives": AlternativesReply;
  "/api/sequences/open": SequenceReply;
  "/api/sequences/save": Saved;
  "/api/undo": WordsUndone;
  "/api/uploads": UploadReply;
  "/api/words": WordsEdited;
}

export interface Put {
  "/api/board": BoardReply;
  "/api/captions": WordsEdited;
  "/api/grammar/rules": GrammarEdited;
  "/api/grammar/terminal": GrammarEdited;
}

export interface Deleted {
  "/api/board": Removed;
  "/api/capture": Removed;
  "/api/grammar": Removed;
  "/api/jobs/{job_id}": JobReply;
  "/api/scene": Removed;
  "/api/selection": CapturesChanged;
}
