/** The tactics board: draw a play, see what cannot be played, make the scene, change it. */

import { named, numberField } from "../../dom/fields.ts";
import { makeState } from "../../dom/state.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, messageOf, post } from "../../api/client.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { askWhether } from "../../parts/asking.ts";
import { banner, faultState, showFault } from "../../parts/states.ts";
import { go, rewrite, routeTo } from "../../shell/router.ts";
import type { Context, OpenView } from "../view.ts";
import { makeDrawing } from "./drawing.ts";
import { dropDraft, keepDraft, olderDraft, readDraft, type Edited } from "./draft.ts";
import {
  blankDiagram,
  addElement,
  addPlayer,
  changeElement,
  changePlayer,
  emptyDiagram,
  moveTo,
  placeBefore,
  removeElement,
  removePlayer,
  type Selection,
} from "./edits.ts";
import { makeFiles } from "./files.ts";
import { makeMaking } from "./making.ts";
import { panelOf } from "./panel.ts";
import { sayFault } from "./reasons.ts";
import { standing } from "./standing.ts";
import { makeTools } from "./tools.ts";
import { endsAtPlace, useGround } from "./verbs.ts";
import type { BoardReply, BoardKinds, DiagramShape } from "../../api/types.ts";
import type { Spot, Team } from "./spot.ts";

/** Milliseconds after the last change before the server is asked about the diagram. */
const PAUSE = 150;
/** Milliseconds after a dragged player has begun to change the scene before the board is checked, so
 * that the scene comes first. Chosen by hand: the reason is still there within half a second. */
const CHECK_AFTER = 250;
const MOST_UNDONE = 200;
/** Where the end of an action that was added by the keyboard lies from its player: up the board. */
const AHEAD: Spot = [0, -1.5];

/** A board that was read, with its reasons for somebody who draws. */
function spoken(board: BoardReply): BoardReply {
  const words = new Map(board.faults.map((one) => [one.message, sayFault(one)]));
  const said = <T extends { reason: string | null }>(one: T): T => ({
    ...one,
    reason: one.reason === null ? null : (words.get(one.reason) ?? one.reason),
  });
  return {
    ...board,
    elements: board.elements.map(said),
    players: board.players.map(said),
    faults: board.faults.map((one) => ({ ...one, message: sayFault(one) })),
  };
}

/** What is known until the page is loaded again. */
const KEPT = {
  /** Whether the scene is large and the board beside it small. */
  isStage: false,
  /** Whether a board was opened: then an address names no scene to begin with. */
  opened: false,
};

const inDialog = (): boolean => document.querySelector("dialog[open]") !== null;

export function open(host: HTMLElement, context: Context): OpenView {
  let name = "";
  /** The text of the file of this board when it was opened or saved; "": a new board. */
  let fileText = "";
  const state = makeState(
    {
      diagram: emptyDiagram(),
      board: null as BoardReply | null,
      kinds: { grammars: [], grounds: [] } as BoardKinds,
      selection: null as Selection,
      undone: [] as DiagramShape[],
      isStage: KEPT.isStage,
    },
    () => show(),
  );
  let dragFrom: DiagramShape | null = null;
  /** Whether the page was just loaded and nobody has drawn here yet. */
  let untouched = false;
  let sceneText = "";
  let timer = 0;
  const latest = makeLatest();
  let route = { board: "", scene: "", job: "" };

  const faults = h("div", { "aria-live": "polite" });
  const draftNote = h("div", { "aria-live": "polite" });
  const side = h("div.board-side");
  const warm = h("input", { type: "checkbox", id: "board-warm", checked: true });
  const seed = numberField("board-seed", 0, { value: 0 });
  const makeButton = button(
    "main",
    "Make the scene",
    () => state.board && making.make(state.board.text, seed.valueAsNumber || 0),
  );
  const undoButton = button("plain", [icon("undo"), "Undo"], () => undo(), { disabled: true });
  const swapButton = button("plain", "", () => swap(), { title: "Exchange their sizes (X)" });
  const body = h("div");
  const tools = makeTools(() => show());
  const files = makeFiles(context, {
    open: (chosen) => go(routeTo("board", { board: chosen })),
    begin: (grammar) => void begin(grammar),
    openText: (text) => void check({ text }, true),
    present: () => ({ name: state.board?.shipped ? `my-${name}` : name, text: state.board?.text ?? "" }),
    saved: (saved) => {
      dropDraft(edited());
      draftNote.replaceChildren();
      name = saved.name;
      fileText = saved.text;
      dropDraft(edited());
      setRoute({ board: saved.name });
      void files.list(saved.name, state.kinds.grammars);
    },
  });
  const making = makeMaking(
    context,
    ({ scene, job, text }) => {
      if (job !== undefined) setRoute({ job: job ?? "" });
      if (scene !== undefined) setRoute({ scene });
      if (text) sceneText = text;
      takeScene();
    },
    (tokens) => drawing.setTokens(tokens),
  );
  const drawing = makeDrawing({
    select: (chosen) => void (state.selection = chosen),
    move: (moved, to, done) => {
      const dragged = dragFrom !== null; // not by a key, which may be held down
      dragFrom ??= state.diagram;
      state.selection = moved;
      state.diagram = moveTo(state.diagram, moved, to);
      if (!done) return;
      remember(dragFrom);
      dragFrom = null;
      changed(true, dragged ? 0 : PAUSE);
    },
    draw: (player, to, other, after) => {
      if (!tools.tool || tools.team) return;
      const target = { to, after, ...(other ? { other } : {}) };
      edit(addElement(state.diagram, tools.tool, player, target));
      selectLast();
    },
    place: (at) => {
      const team = tools.team;
      if (team) place(team, at);
      else state.selection = null;
    },
    remove: () => removeSelected(),
    bend: (index, at) => {
      const element = state.diagram.elements[index]!;
      edit(changeElement(state.diagram, index, { via: [...element.via, at] }));
      state.selection = { what: "element", index, point: element.via.length };
    },
  });

  function edited(): Edited {
    return { database: context.status().database, name, text: fileText };
  }

  function setRoute(change: Partial<typeof route>): void {
    route = { ...route, ...change };
    rewrite(routeTo("board", route));
  }

  function remember(before: DiagramShape): void {
    state.undone = [...state.undone.slice(-MOST_UNDONE), before];
  }

  /** Take a changed diagram; the server checks it. */
  function edit(next: DiagramShape): void {
    remember(state.diagram);
    state.diagram = next;
    changed(true);
  }

  /** Show the board of the scene that an address names, unless there is one. */
  function takeScene(): void {
    if (!sceneText || !untouched || !state.board) return;
    untouched = false;
    void check({ text: sceneText }, true);
  }

  function undo(): void {
    const before = state.undone.at(-1);
    if (!before) return;
    state.undone = state.undone.slice(0, -1);
    state.diagram = before;
    state.selection = null;
    changed(true);
  }

  function place(team: Team, at: Spot): void {
    const [next, added] = addPlayer(state.diagram, team, at);
    edit(next);
    state.selection = { what: "player", name: added };
  }

  function selectLast(): void {
    const index = state.diagram.elements.length - 1;
    state.selection = { what: "element", index, point: state.diagram.elements[index]?.to ? "end" : null };
  }

  function removeSelected(): void {
    if (!state.selection || state.selection.what === "place") return; // a place belongs to the grammar
    const next =
      state.selection.what === "player"
        ? removePlayer(state.diagram, state.selection.name)
        : removeElement(state.diagram, state.selection.index);
    state.selection = null;
    edit(next);
  }

  function changed(update: boolean, pause = PAUSE): void {
    untouched = false;
    keepDraft(edited(), state.diagram);
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      const follows = update && warm.checked;
      // After a drag nearly every board that could be played still can: do not wait for the answer.
      const atOnce = follows && pause === 0 && state.board?.feasible;
      if (atOnce) {
        making.update({ diagram: state.diagram });
        timer = window.setTimeout(() => void check({ diagram: state.diagram }, false), CHECK_AFTER);
        return;
      }
      void check({ diagram: state.diagram }, false).then(() => {
        if (follows && state.board?.feasible) making.update({ text: state.board.text });
      });
    }, pause);
  }

  async function check(body: { diagram: DiagramShape } | { text: string }, take: boolean): Promise<void> {
    try {
      learn(await latest(post("/api/board/check", body)), take);
    } catch (fault) {
      if (isAbort(fault)) return;
      fill(faults, banner(messageOf(fault)));
    }
  }

  function learn(answer: BoardReply, take: boolean): void {
    if (take && answer.diagram) {
      if (state.board) {
        remember(state.diagram);
        untouched = false;
        keepDraft(edited(), answer.diagram);
      }
      state.diagram = answer.diagram;
      state.selection = null;
    }
    state.board = answer.diagram ? spoken(answer) : answer;
    if (!answer.diagram) {
      state.diagram = blankDiagram(); // nobody stands on a board that cannot be read
      const edit = { label: "Edit the text…", run: () => files.editText() };
      fill(faults, faultState(answer.fault ?? "The text is not a diagram.", [edit]));
    } else showFaults(state.board);
  }

  function showFaults(answer: BoardReply): void {
    const about = new Set(
      answer.elements.map((one) => one.reason).concat(answer.players.map((one) => one.reason)),
    );
    const others = answer.faults.filter((one) => !about.has(one.message)).map((one) => one.message);
    const missing = answer.without_clips;
    fill(
      faults,
      others.map((one) => banner(one)),
      answer.feasible && missing.length
        ? banner(
            `No capture of this database shows ${missing.join(", ")}, so this play cannot be made here. Add captures of ${missing.length === 1 ? "it" : "them"}.`,
          )
        : null,
    );
  }

  function show(): void {
    body.className = state.isStage ? "board-body stage" : "board-body";
    swapButton.textContent = state.isStage ? "Larger board" : "Larger scene";
    undoButton.disabled = state.undone.length === 0;
    if (!state.board) return;
    const ground = state.kinds.grounds.find((one) => one.grammar === state.diagram.grammar);
    useGround(ground ?? null);
    if (ground) tools.setGround(ground);
    making.setGround({ ground: state.diagram.ground, places: state.diagram.places });
    making.stand(standing(state.diagram));
    drawing.show(state.diagram, state.board, state.selection, tools.tool);
    fill(
      side,
      panelOf(state.diagram, state.board, state.selection, ground?.verbs.map((one) => one.name) ?? [], {
        changeElement: (index, change) => edit(changeElement(state.diagram, index, change)),
        changePlayer: (player, change) => edit(changePlayer(state.diagram, player, change)),
        changeBall: (ball) => edit({ ...state.diagram, ball }),
        addElement: (player, kind, after) => {
          const end = after === null ? null : state.diagram.elements[after]!.to;
          const [x, z] = end ?? placeBefore(state.diagram, player, Infinity);
          const to: Spot = [x + AHEAD[0], z + AHEAD[1]];
          edit(addElement(state.diagram, kind, player, { after, ...(endsAtPlace(kind) ? { to } : {}) }));
          selectLast();
        },
        select: (chosen) => void (state.selection = chosen),
        remove: removeSelected,
      }),
    );
    makeButton.disabled = !state.board?.feasible || state.board.without_clips.length > 0;
    makeButton.title = makeButton.disabled ? "This play cannot be made yet; see the reasons." : "";
  }

  /** Make the scene larger and the board smaller, or the other way round. */
  function swap(): void {
    KEPT.isStage = state.isStage = !state.isStage;
  }
  show();

  fill(body, [
    h("div.board-left", tools.element, side),
    drawing.element,
    h(
      "div.board-right",
      h(
        "div.row",
        makeButton,
        named("Seed", seed),
        undoButton,
        h("label.check", warm, "update after changes"),
        swapButton,
      ),
      faults,
      making.element,
    ),
  ]);
  fill(host, h("h1.hidden-heading", "Tactics board"), h("div.row.board-bar", files.element), draftNote, body);
  // A button that was pressed and is disabled now leaves the focus to the page.
  const onKey = (event: KeyboardEvent): void => {
    const at = event.target as Element;
    if (at !== document.body && !host.contains(at)) return;
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey && !event.repeat;
    if (event.key === "x" && plain && !at.matches("input, textarea, select") && !inDialog()) swap();
    else if ((event.ctrlKey || event.metaKey) && event.key === "z" && !at.matches("input, textarea")) {
      event.preventDefault();
      undo();
    } else if (event.key === "Escape") {
      state.selection = null;
      tools.clear();
      show();
    }
  };
  document.addEventListener("keydown", onKey);

  async function load(wanted: string): Promise<void> {
    state.undone = [];
    state.selection = null;
    name = wanted;
    fileText = "";
    state.board = null;
    try {
      if (state.kinds.grammars.length === 0) state.kinds = await get("/api/board/kinds");
      void files.list(wanted, state.kinds.grammars);
      const first = !KEPT.opened;
      KEPT.opened = true;
      untouched = first && !wanted && !readDraft(edited());
      draftNote.replaceChildren();
      if (wanted) {
        const saved = await get("/api/board", { name: wanted });
        if (name !== wanted) return;
        fileText = saved.text;
        learn(saved, true);
      }
      const draft = readDraft(edited());
      if (!draft && !wanted) await check({ diagram: emptyDiagram(state.kinds.grounds[0]) }, true);
      if (draft) {
        if (wanted) state.undone = [state.diagram];
        state.board = null;
        await check({ diagram: draft }, true);
        showDraftNote();
      } else showOlderNote();
      takeScene();
    } catch (fault) {
      showFault(faults, fault);
    }
  }

  /** Say that this drawing was not saved, and what can be done with it. */
  function showDraftNote(): void {
    const what = name ? `This is ${name} with your unsaved changes.` : "This is your unsaved drawing.";
    const text = `${what} This browser keeps it until you save or discard it.`;
    fill(draftNote, banner(text, [{ label: "Discard…", plain: true, run: () => void discard() }]));
  }

  /** Say that a drawing of an earlier file of this board is kept. */
  function showOlderNote(): void {
    const [older, which] = [olderDraft(edited()), edited()];
    if (!older) return;
    const text = `The file of ${name} was changed since you drew on it. Your unsaved drawing of the earlier one is kept here.`;
    const show = (): void => {
      keepDraft(which, older);
      void load(which.name);
    };
    const forget = (): void => {
      dropDraft(which);
      draftNote.replaceChildren();
    };
    fill(
      draftNote,
      banner(text, [
        { label: "Show my drawing", run: show },
        { label: "Discard it", plain: true, run: forget },
      ]),
    );
  }

  /** Ask before a drawing that was not saved is dropped; false: it stays. */
  async function mayDrop(which: Edited): Promise<boolean> {
    if (!readDraft(which)) return true;
    const sure = await askWhether(
      "Discard the unsaved drawing?",
      which.name
        ? `The changes of ${which.name} since it was saved are lost.`
        : "A new board was drawn before, and not saved as a board.",
      "Discard",
    );
    if (sure) dropDraft(which);
    return sure;
  }

  async function discard(): Promise<void> {
    if (await mayDrop(edited())) void load(name);
  }

  /** Begin a new board on the ground of a grammar; the present one stays as a draft of its name. */
  async function begin(grammar: string): Promise<void> {
    if (!(await mayDrop({ ...edited(), name: "", text: "" }))) {
      void files.list(name, state.kinds.grammars);
      return;
    }
    if (name) {
      name = fileText = "";
      route = { board: "", scene: "", job: "" };
      history.pushState(null, "", routeTo("board", route)); // Back returns to the other board
    }
    making.clear();
    state.undone = [];
    state.selection = state.board = null;
    untouched = false;
    draftNote.replaceChildren();
    void files.list("", state.kinds.grammars);
    const ground = state.kinds.grounds.find((one) => one.grammar === grammar) ?? null;
    const next = emptyDiagram(ground ?? undefined);
    keepDraft(edited(), next);
    await check({ diagram: next }, true);
  }

  return {
    update(parameters) {
      const wanted = parameters.get("board") ?? "";
      const first = state.kinds.grammars.length === 0;
      route = { board: wanted, scene: parameters.get("scene") ?? "", job: parameters.get("job") ?? "" };
      if (first || wanted !== name) void load(wanted);
      making.open(route.scene || null, route.job || null);
    },
    close() {
      document.removeEventListener("keydown", onKey);
      clearTimeout(timer);
      making.close();
    },
  };
}
