/** Make the scene of a board: show its error while it is sampled, play it, and update it when the board changes. */

import { onSubmit } from "../../dom/fields.ts";
import { REDUCED } from "../../dom/wishes.ts";
import { get, post } from "../../api/client.ts";
import { cancelJob, failureOf, isActive, stepOf } from "../../api/jobs.ts";
import type { Track } from "../../api/container.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { download } from "../../parts/download.ts";
import { progressBar } from "../../parts/progress.ts";
import { faultState, showFault } from "../../parts/states.ts";
import { makePlayer } from "../../player/player.ts";
import type { Context } from "../view.ts";
import { makeErrorCurve } from "./curve.ts";
import { sceneReport } from "./rules.ts";
import { makeCourt, type CourtPlan } from "../../player/court.ts";
import { tokensAt, type Token } from "./tokens.ts";
import type { DiagramShape, JobReply } from "../../api/types.ts";

export function makeMaking(
  context: Context,
  went: (state: { scene?: string; job?: string | null; text?: string }) => void,
  /** Where everybody is now; nobody at the beginning of a scene that does not play. */
  moved: (tokens: readonly Token[]) => void,
) {
  const player = makePlayer(context.stage, { label: "The scene" });
  const court = makeCourt(player.screen);
  let playing: readonly Track[] = [];
  player.onTime((time) => {
    const begun = time > player.screen.playback.from + 1e-6 || player.screen.playback.playing;
    moved(begun ? tokensAt(playing, time) : []);
  });
  const curve = makeErrorCurve();
  const state = h("div.board-making", { "aria-live": "polite" });
  const report = h("div");
  const buttons = h("div.row", { hidden: true });
  const element = h(
    "section.board-scene",
    { "aria-label": "Scene" },
    state,
    player.element,
    report,
    buttons,
    curve.element,
  );
  let scene: string | null = null;
  let ground = "";
  /** Whether people stand there and nothing plays; and those of the drawing. */
  let stands = false;
  let people: Track[] = [];
  let watched: { id: string; source: EventSource } | null = null;

  /** What this is for, while there is nothing. */
  function sayIdle(): void {
    const text = "Make the scene: the people of the drawing move with motion of the captures.";
    fill(state, h("p.muted", text));
  }
  sayIdle();

  function stop(): void {
    watched?.source.close();
    watched = null;
  }

  function tell(job: JobReply): void {
    fill(
      state,
      h("p", h("b", job.title), job.error === null ? "" : ` error ${job.error.toPrecision(3)}`),
      progressBar(job.state === "waiting" ? null : job.share, stepOf(job)),
      button("plain", "Cancel", () => void cancelJob(job)),
    );
  }

  function ended(job: JobReply): void {
    stop();
    went({ job: null });
    if (job.result?.kind !== "scene" && !scene) rest();
    if (job.result?.kind === "scene") {
      state.replaceChildren();
      void show(job.result.ref);
    } else if (job.state === "failed") {
      fill(state, faultState(failureOf(job)));
    } else if (job.kind === "scene") {
      fill(state, h("p.muted", "Cancelled."));
    } else if (scene) state.replaceChildren();
    else sayIdle();
  }

  function watch(id: string): void {
    stop();
    const source = new EventSource(`/api/jobs/${encodeURIComponent(id)}/events`);
    watched = { id, source };
    let points: [number, number][] = [];
    let last: JobReply | null = null;
    source.addEventListener("job", (event) => {
      const job = JSON.parse(event.data) as JobReply;
      if (job.preview && job.preview !== last?.preview && isActive(job)) void showFirst(job.preview, id);
      last = job;
      if (job.curve) points = [...job.curve];
      if (job.kind === "scene") curve.show(points);
      if (isActive(job)) tell(job);
      else ended(job);
    });
    source.addEventListener("progress", (event) => {
      const news = JSON.parse((event as MessageEvent<string>).data) as Pick<
        JobReply,
        "what" | "share" | "error" | "preview"
      >;
      if (!last) return;
      if (news.preview && news.preview !== last.preview) void showFirst(news.preview, id);
      last = { ...last, ...news, state: "running" };
      if (news.error !== null && last.kind === "scene") {
        points.push([news.share, news.error]);
        curve.show(points);
      }
      tell(last);
    });
  }

  async function begin(path: "/api/scenes" | "/api/scenes/update", body: unknown): Promise<void> {
    try {
      const job = await post(path, body);
      went({ job: job.id });
      watch(job.id);
    } catch (fault) {
      showFault(state, fault);
    }
  }

  /** Let the people of the drawing stand there, if no scene does. */
  function rest(): void {
    playing = [];
    moved([]);
    stands = false;
    stand(people);
  }

  function stand(tracks: Track[]): void {
    people = tracks;
    if (scene || playing.length) return;
    player.show({ tracks }, stands);
    stands = tracks.length > 0;
    player.element.classList.toggle("still", stands);
  }

  async function show(ref: string): Promise<void> {
    const first = scene === null && playing.length === 0;
    try {
      const [facts, tracks] = await Promise.all([get("/api/scene", { ref }), context.motions.tracks(ref)]);
      scene = ref;
      if (!watched) state.replaceChildren();
      went({ scene: ref, text: facts.text });
      play(tracks, first);
      if (facts.curve.length) curve.show(facts.curve);
      fill(
        report,
        sceneReport(facts, (at) => {
          player.screen.setPlayback({ ...player.screen.playback, playing: false });
          player.seek(at);
        }),
      );
      showButtons(ref);
    } catch (fault) {
      showFault(state, fault);
    }
  }

  /** Play the first motion of an update while its report is being made. */
  async function showFirst(ref: string, job: string): Promise<void> {
    try {
      const tracks = await context.motions.tracks(ref);
      if (watched?.id === job) play(tracks, false);
    } catch {
      // the whole scene follows
    }
  }

  function play(tracks: Track[], first: boolean): void {
    const { time, playing: wasPlaying } = player.screen.playback;
    first ||= stands;
    playing = tracks;
    stands = false;
    player.element.classList.remove("still");
    player.show({ tracks }, !first);
    if (wasPlaying || (first && !REDUCED.matches)) player.play();
    if (!first) player.seek(Math.min(time, player.screen.playback.duration));
  }

  function keep(ref: string): void {
    const name = h("input.field", { "aria-label": "Name of the scene", required: true });
    const form = h("form.row", name, h("button.button", { type: "submit" }, "Keep"));
    onSubmit(form, () => {
      post("/api/scenes/keep", { ref, name: name.value.trim() }).then(() => {
        context.notify(`Kept as ${name.value.trim()}.`);
        showButtons(ref);
      }, context.fail);
    });
    fill(buttons, form);
    name.focus();
  }

  function showButtons(ref: string): void {
    buttons.hidden = false;
    fill(
      buttons,
      button("plain", "Download", () => void download([{ ref }], "bvh")),
      context.status().read_only ? null : button("plain", "Keep in the database…", () => keep(ref)),
    );
  }

  return {
    element,
    /** The scene on screen; null before the first. */
    get scene() {
      return scene;
    },
    make(text: string, seed: number): void {
      curve.show([]);
      void begin("/api/scenes", { text, seed });
    },
    /** Update the current scene to a changed diagram; without a scene nothing happens. */
    update(board: { text: string } | { diagram: DiagramShape }): void {
      if (scene) void begin("/api/scenes/update", { scene, ...board });
    },
    /** Show no scene: another play begins. */
    clear(): void {
      stop();
      scene = null;
      playing = [];
      buttons.hidden = true;
      report.replaceChildren();
      sayIdle();
      curve.show([]);
      moved([]);
    },
    /** Draw the ground of the board under the scene. */
    setGround(plan: CourtPlan): void {
      const { width, length, left, back } = plan.ground;
      const size = [width, length, left, back].join(" ");
      if (size !== ground) stands = false; // those of another ground are looked at from elsewhere
      ground = size;
      court.show(plan);
    },
    /** Let the people of the drawing stand there, while there is no scene. */
    stand,
    /** Show a scene, or watch a job that makes one. */
    open(ref: string | null, job: string | null): void {
      if (job && job !== watched?.id) watch(job);
      else if (ref && ref !== scene) void show(ref);
    },
    close(): void {
      stop();
      court.close();
      player.close();
    },
  };
}

export type Making = ReturnType<typeof makeMaking>;
