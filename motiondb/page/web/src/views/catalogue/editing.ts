/** Editing words: the sentence of a whole capture in its row, and every caption in the panel. */

import { ApiError, post, put } from "../../api/client.ts";
import type { Caption, WordsEdited } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { askWhether } from "../../parts/asking.ts";
import type { Context } from "../view.ts";

/** Captions with the sentences of the whole capture replaced by a line "one; another". */
export function withWholeWords(captions: readonly Caption[], line: string): Caption[] {
  const sentences = line
    .split(";")
    .map((one) => one.trim())
    .filter((one) => one !== "");
  const whole = sentences.map((words): Caption => ({ words, start: null, end: null }));
  return [...whole, ...captions.filter((one) => one.start !== null)];
}

/** Word edits, each announced with a way to undo it. */
export function makeWordsActions(context: Context, edited: (capture: string, words: Caption[]) => void) {
  async function run(request: () => Promise<WordsEdited>): Promise<WordsEdited | null> {
    try {
      const answer = await request();
      edited(answer.capture, answer.words);
      const fresh =
        answer.new_words.length > 0
          ? ` New to this database: ${answer.new_words.join(", ")}. They are found where they are written; learning again ties them to motion.`
          : "";
      context.notify(`Words of ${answer.capture} saved.${fresh}`, { label: "Undo", run: () => void undo() });
      return answer;
    } catch (fault) {
      context.fail(fault);
      return null;
    }
  }

  async function undo(): Promise<void> {
    const answer = await post("/api/undo", {});
    edited(answer.capture, answer.words);
    const more = answer.captures > 1 ? ` and ${answer.captures - 1} more` : "";
    const what = {
      words: "edit of words",
      tags: "edit of tags",
      selection: "change of a selection",
      name: "new name",
      removal: "removal",
    }[answer.what];
    context.notify(`The last ${what ?? "edit"} of ${answer.capture}${more} is undone.`);
    void context.refresh();
  }

  async function replace(
    capture: string,
    captions: readonly Caption[],
    before: readonly Caption[],
  ): Promise<WordsEdited | null> {
    const body = { capture, words: captions };
    try {
      const answer = await put("/api/captions", { ...body, before });
      return await run(() => Promise.resolve(answer));
    } catch (fault) {
      if (!(fault instanceof ApiError && fault.kind === "ConflictError")) {
        context.fail(fault);
        return null;
      }
      const mine = captions.map((one) => one.words).join("; ") || "none";
      const sure = await askWhether(
        "These words were changed meanwhile",
        `${fault.message}\nYours: ${mine}.`,
        "Replace them by mine",
      );
      return sure ? run(() => put("/api/captions", body)) : null;
    }
  }

  return {
    /**
     * Replace all captions of a capture; resolves with the new captions, or null on failure.
     * `before`: the captions that were edited. Where others are there now, the user is asked.
     */
    replace,
    /** Add a caption to a part of a capture. */
    addPart: (capture: string, words: string, start: number, end: number) =>
      run(() => post("/api/words", { capture, words, start, end, keep: true })),
    undo,
  };
}

export type WordsActions = ReturnType<typeof makeWordsActions>;

/** Whether words are being typed somewhere in an element: it must not be drawn again then. */
export function isEditing(element: HTMLElement): boolean {
  return element.querySelector("input.in-place:not(:disabled)") !== null;
}

/** Put an input into a cell. Enter or leaving the input saves, Escape cancels; then `done` is called. */
export function editInPlace(
  cell: HTMLElement,
  value: string,
  label: string,
  save: (value: string) => Promise<unknown>,
  done: () => void,
): void {
  let finished = false;
  const input = h("input.in-place", {
    value,
    "aria-label": label,
    placeholder: "a person walks; walking",
  });
  async function finish(keep: boolean): Promise<void> {
    if (finished) return;
    finished = true;
    input.disabled = true;
    if (keep && input.value.trim() !== value.trim()) await save(input.value);
    input.remove();
    done();
  }
  input.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Enter") void finish(true);
    if (event.key === "Escape") void finish(false);
  });
  // Another window may take the focus: that is no end of typing. Nor is it one to be drawn over.
  input.addEventListener(
    "blur",
    () => document.activeElement !== input && input.isConnected && void finish(true),
  );
  fill(cell, input);
  input.focus();
  input.setSelectionRange(0, value.length, "backward"); // of a long line the beginning is seen
}

/** The captions of one capture: each can be changed, removed, or played. */
export function makeCaptionList(actions: WordsActions, play: (start: number, end: number) => void) {
  const element = h("div.captions");
  let shown = "";

  function row(capture: string, captions: readonly Caption[], index: number, canEdit: boolean): HTMLElement {
    const caption = captions[index]!;
    const { start, end, words } = caption;
    const others = captions.filter((_, i) => i !== index);
    const cell = h("div.caption-words");
    const reset = (): void =>
      fill(
        cell,
        canEdit
          ? h(
              "button.words-button",
              { type: "button", title: "Edit these words", on: { click: begin } },
              words,
            )
          : words,
      );
    const begin = (): void =>
      editInPlace(
        cell,
        words,
        "Words",
        async (value) => {
          const changed =
            value.trim() === ""
              ? others
              : captions.map((one, i) => (i === index ? { ...one, words: value.trim() } : one));
          return actions.replace(capture, changed, captions);
        },
        reset,
      );
    reset();
    const when =
      start === null || end === null
        ? h("span.muted", "whole")
        : button("time", `${start.toFixed(2)}–${end.toFixed(2)}`, () => play(start, end), {
            title: "Play this part",
          });
    const removal = canEdit
      ? button("tool", icon("close"), () => void actions.replace(capture, others, captions), {
          "aria-label": `Remove “${words}”`,
          title: "Remove",
        })
      : null;
    return h("li.caption", when, cell, removal);
  }

  return {
    element,
    show(capture: string, captions: readonly Caption[], canEdit: boolean): void {
      const former = element.querySelector<HTMLInputElement>("form input");
      const typed = shown === capture ? (former?.value ?? "") : "";
      const focused = former !== null && document.activeElement === former;
      shown = capture;
      const input = h("input.field", {
        "aria-label": "Words of the whole capture",
        placeholder: "Say what happens in this capture",
        value: typed,
      });
      const form = h(
        "form.row",
        {
          on: {
            submit: (event) => {
              event.preventDefault();
              const words = input.value.trim();
              if (!words) return input.focus();
              input.value = "";
              void actions
                .replace(capture, [...captions, { words, start: null, end: null }], captions)
                .then((saved) => saved ?? (input.value = words));
            },
          },
        },
        input,
        h("button.button.plain", { type: "submit" }, "Add words"),
      );
      fill(
        element,
        captions.length > 0
          ? h(
              "ul.plain",
              captions.map((_, i) => row(capture, captions, i, canEdit)),
            )
          : h("p.muted", "Nobody has written about this capture yet."),
        canEdit ? form : null,
      );
      if (focused && canEdit) input.focus();
    },
  };
}
