/** The interface of a view, and the context that the shell passes to it. Each view has its own folder. */

import type { Live, News } from "../api/live.ts";
import type { Motions } from "../api/motions.ts";
import type { Status } from "../api/types.ts";
import type { Stage } from "../player/stage.ts";
import type { Route } from "../shell/router.ts";

export interface Context {
  readonly stage: Stage;
  readonly motions: Motions;
  readonly live: Live;
  /** The last known state of the database. */
  status(): Status;
  /** Ask for the state again; the view is told if the revision is another. */
  refresh(): Promise<Status>;
  /** A short message that goes away by itself, with an action if given. */
  notify(text: string, action?: { label: string; run: () => void }): void;
  /** A fault, shown until it is closed. */
  fail(fault: unknown): void;
}

/** A view on screen. */
export interface OpenView {
  /** Called when the parameters of the route change, and once at the start. */
  update(parameters: URLSearchParams): void;
  news?(news: News): void;
  /** Called before another view is opened, which waits for it. */
  leave?(route: Route): Promise<void>;
  /** Where the question box stands in place of the head of the page; null: there. */
  slot?(): HTMLElement | null;
  close(): void;
}

export interface View {
  /** The name in the address. */
  readonly name: string;
  /** The word in the navigation; "" for the first view. */
  readonly title: string;
  /** Where it is reached: the navigation if absent, its menu "Explore", or only by asking. */
  readonly place?: "explore" | "asking";
  /** Whether nothing plays on the stage, which is then not loaded. */
  readonly flat?: boolean;
  load(): Promise<{ open(host: HTMLElement, context: Context): OpenView }>;
}
