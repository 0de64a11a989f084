/** The tactics board: draw a play, see what cannot be played, make the scene, change it. */

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

/** Whether the scene is large and the board beside it small, until the page is loaded again. */
let isStage = false;
/** Whether a board was opened since the page was loaded: then an address names no scene to begin with. */
let opened = false;

const inDialog = (): boolean => document.querySelector("dialog[open]") !== null;

export function open(host: HTMLElement, context: Context): OpenView {
  let name = "";
  /** The text of the file of this board when it was opened or saved; "": a new board. */
  let fileText = "";
  let diagram: DiagramShape = emptyDiagram();
  let board: BoardReply | null = null;
  let kinds: BoardKinds = { grammars: [], grounds: [] };
  let selection: Selection = null;
  let undone: DiagramShape[] = [];
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
  const seed = h("input.number", { type: "number", id: "board-seed", min: 0, step: 1, value: 0 });
  const makeButton = button(
    "main",
    "Make the scene",
    () => board && making.make(board.text, seed.valueAsNumber || 0),
  );
  const undoButton = button("plain", [icon("undo"), "Undo"], () => undo(), { disabled: true });
  const swapButton = button("plain", "", () => swap(), { title: "Exchange their sizes (X)" });
  const body = h("div");
  const tools = makeTools(() => show());
  const files = makeFiles(context, {
    open: (chosen) => go(routeTo("board", { board: chosen })),
    begin: (grammar) => void begin(grammar),
    openText: (text) => void check({ text }, true),
    present: () => ({ name: board?.shipped ? `my-${name}` : name, text: board?.text ?? "" }),
    saved: (saved) => {
      dropDraft(edited());
      draftNote.replaceChildren();
      name = saved.name;
      fileText = saved.text;
      dropDraft(edited());
      setRoute({ board: saved.name });
      void files.list(saved.name, kinds.grammars);
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
    select: (chosen) => {
      selection = chosen;
      show();
    },
    move: (moved, to, done) => {
      const dragged = dragFrom !== null; // not by a key, which may be held down
      dragFrom ??= diagram;
      selection = moved;
      diagram = moveTo(diagram, moved, to);
      show();
      if (!done) return;
      remember(dragFrom);
      dragFrom = null;
      changed(true, dragged ? 0 : PAUSE);
    },
    draw: (player, to, other, after) => {
      if (!tools.tool || tools.team) return;
      const target = { to, after, ...(other ? { other } : {}) };
      edit(addElement(diagram, tools.tool, player, target));
      selectLast();
    },
    place: (at) => {
      const team = tools.team;
      if (!team) {
        selection = null;
        return show();
      }
      place(team, at);
    },
    remove: () => removeSelected(),
    bend: (index, at) => {
      const element = diagram.elements[index]!;
      edit(changeElement(diagram, index, { via: [...element.via, at] }));
      selection = { what: "element", index, point: element.via.length };
      show();
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
    undone = [...undone.slice(-MOST_UNDONE), before];
    undoButton.disabled = false;
  }

  /** Take a changed diagram; the server checks it. */
  function edit(next: DiagramShape): void {
    remember(diagram);
    diagram = next;
    changed(true);
    show();
  }

  /** Show the board of the scene that an address names, unless there is one. */
  function takeScene(): void {
    if (!sceneText || !untouched || !board) return;
    untouched = false;
    void check({ text: sceneText }, true);
  }

  function undo(): void {
    const before = undone.pop();
    if (!before) return;
    diagram = before;
    undoButton.disabled = undone.length === 0;
    selection = null;
    changed(true);
    show();
  }

  function place(team: Team, at: Spot): void {
    const [next, added] = addPlayer(diagram, team, at);
    edit(next);
    selection = { what: "player", name: added };
    show();
  }

  function selectLast(): void {
    const index = diagram.elements.length - 1;
    selection = { what: "element", index, point: diagram.elements[index]?.to ? "end" : null };
    show();
  }

  function removeSelected(): void {
    if (!selection || selection.what === "place") return; // a place belongs to the grammar
    const next =
      selection.what === "player"
        ? removePlayer(diagram, selection.name)
        : removeElement(diagram, selection.index);
    selection = null;
    edit(next);
  }

  function changed(update: boolean, pause = PAUSE): void {
    untouched = false;
    keepDraft(edited(), diagram);
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      const follows = update && warm.checked;
      // After a drag nearly every board that could be played still can: do not wait for the answer.
      const atOnce = follows && pause === 0 && board?.feasible;
      if (atOnce) {
        making.update({ diagram });
        timer = window.setTimeout(() => void check({ diagram }, false), CHECK_AFTER);
        return;
      }
      void check({ diagram }, false).then(() => {
        if (follows && board?.feasible) making.update({ text: board.text });
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
      if (board) {
        remember(diagram);
        untouched = false;
        keepDraft(edited(), answer.diagram);
      }
      diagram = answer.diagram;
      selection = null;
    }
    board = answer.diagram ? spoken(answer) : answer;
    if (!answer.diagram) {
      diagram = blankDiagram(); // nobody stands on a board that cannot be read
      const edit = { label: "Edit the text…", run: () => files.editText() };
      fill(faults, faultState(answer.fault ?? "The text is not a diagram.", [edit]));
    } else showFaults(board);
    show();
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
    const ground = kinds.grounds.find((one) => one.grammar === diagram.grammar);
    useGround(ground ?? null);
    if (ground) tools.setGround(ground);
    making.setGround({ ground: diagram.ground, places: diagram.places });
    making.stand(standing(diagram));
    drawing.show(diagram, board, selection, tools.tool);
    fill(
      side,
      panelOf(diagram, board, selection, ground?.verbs.map((one) => one.name) ?? [], {
        changeElement: (index, change) => edit(changeElement(diagram, index, change)),
        changePlayer: (player, change) => edit(changePlayer(diagram, player, change)),
        changeBall: (ball) => edit({ ...diagram, ball }),
        addElement: (player, kind, after) => {
          const end = after === null ? null : diagram.elements[after]!.to;
          const [x, z] = end ?? placeBefore(diagram, player, Infinity);
          const to: Spot = [x + AHEAD[0], z + AHEAD[1]];
          edit(addElement(diagram, kind, player, { after, ...(endsAtPlace(kind) ? { to } : {}) }));
          selectLast();
        },
        select: (chosen) => {
          selection = chosen;
          show();
        },
        remove: removeSelected,
      }),
    );
    makeButton.disabled = !board?.feasible || board.without_clips.length > 0;
    makeButton.title = makeButton.disabled ? "This play cannot be made yet; see the reasons." : "";
  }

  /** Make the scene larger and the board smaller, or the other way round. */
  function swap(to = !isStage): void {
    isStage = to;
    body.className = isStage ? "board-body stage" : "board-body";
    swapButton.textContent = isStage ? "Larger board" : "Larger scene";
  }
  swap(isStage);

  fill(body, [
    h("div.board-left", tools.element, side),
    drawing.element,
    h(
      "div.board-right",
      h(
        "div.row",
        makeButton,
        h("label", { for: "board-seed" }, "Seed"),
        seed,
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
      selection = null;
      tools.clear();
      show();
    }
  };
  document.addEventListener("keydown", onKey);

  async function load(wanted: string): Promise<void> {
    undone = [];
    undoButton.disabled = true;
    selection = null;
    name = wanted;
    fileText = "";
    board = null;
    try {
      if (kinds.grammars.length === 0) kinds = await get("/api/board/kinds");
      void files.list(wanted, kinds.grammars);
      const first = !opened;
      opened = true;
      untouched = first && !wanted && !readDraft(edited());
      draftNote.replaceChildren();
      if (wanted) {
        const saved = await get("/api/board", { name: wanted });
        if (name !== wanted) return;
        fileText = saved.text;
        learn(saved, true);
      }
      const draft = readDraft(edited());
      if (!draft && !wanted) await check({ diagram: emptyDiagram(kinds.grounds[0]) }, true);
      if (draft) {
        if (wanted) undone = [diagram];
        board = null;
        await check({ diagram: draft }, true);
        undoButton.disabled = undone.length === 0;
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
      void files.list(name, kinds.grammars);
      return;
    }
    if (name) {
      name = fileText = "";
      route = { board: "", scene: "", job: "" };
      history.pushState(null, "", routeTo("board", route)); // Back returns to the other board
    }
    making.clear();
    undone = [];
    undoButton.disabled = true;
    selection = board = null;
    untouched = false;
    draftNote.replaceChildren();
    void files.list("", kinds.grammars);
    const ground = kinds.grounds.find((one) => one.grammar === grammar) ?? null;
    const next = emptyDiagram(ground ?? undefined);
    keepDraft(edited(), next);
    await check({ diagram: next }, true);
  }

  return {
    update(parameters) {
      const wanted = parameters.get("board") ?? "";
      const first = kinds.grammars.length === 0;
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
