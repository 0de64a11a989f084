/** Where a view was scrolled to, for the way back to it. */

/** Milliseconds for which content may still arrive, and the place be found again. */
const PATIENCE = 4000;

export function keepPlaces() {
  history.scrollRestoration = "manual"; // the content is not there yet when the browser would
  const places = new Map<string, [page: number, table: number]>();
  const tableNow = (): Element | null => document.querySelector(".table");
  let entry = "";
  let shown = "";
  let wanted: [number, number] | null = null;
  let until = 0;

  function remember(): void {
    if (entry && !wanted) places.set(entry, [scrollY, tableNow()?.scrollTop ?? 0]);
  }

  function restore(): void {
    if (!wanted || performance.now() > until) return void (wanted = null);
    const table = tableNow();
    scrollTo(0, wanted[0]);
    if (table) table.scrollTop = wanted[1];
    const there =
      Math.abs(scrollY - wanted[0]) < 2 && (!wanted[1] || Math.abs((table?.scrollTop ?? 0) - wanted[1]) < 2);
    if (there) wanted = null;
    else requestAnimationFrame(restore);
  }

  addEventListener("scroll", remember, { passive: true, capture: true });
  for (const kind of ["wheel", "pointerdown", "keydown"]) {
    addEventListener(kind, () => (wanted = null), { passive: true }); // the user scrolls
  }

  return {
    /**
     * A view is shown: where the user comes back to it, it is scrolled to where it was; another one is
     * shown from its top. `about`: the same text for the same content.
     */
    arrive(about: string): void {
      const state = history.state as { entry?: string } | null;
      const known = state?.entry ?? "";
      if (known === entry && known) return; // the same step of the history
      if (!known) {
        entry = crypto.randomUUID?.() ?? String(Math.random());
        history.replaceState({ ...state, entry }, "");
        wanted = null;
        if (about !== shown) scrollTo(0, 0);
        shown = about;
        return;
      }
      entry = known;
      shown = about;
      wanted = places.get(known) ?? null;
      until = performance.now() + PATIENCE;
      restore();
    },
  };
}

export type Places = ReturnType<typeof keepPlaces>;
