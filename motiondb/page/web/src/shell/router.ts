/** Views live in the hash of the address: `#/search?q=walk`. */

export interface Route {
  view: string;
  parameters: URLSearchParams;
}

/** The route of a hash; an empty hash is the first view. */
export function parseRoute(hash: string, first: string): Route {
  const [path, query] = hash.replace(/^#\/?/, "").split("?", 2);
  return { view: path || first, parameters: new URLSearchParams(query ?? "") };
}

/** The hash of a view with parameters; empty ones are left out. */
export function routeTo(
  view: string,
  parameters: Record<string, string | number | null | undefined> = {},
): string {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    if (value !== null && value !== undefined && value !== "") query.set(name, String(value));
  }
  const text = query.toString();
  return text ? `#/${view}?${text}` : `#/${view}`;
}

/** Go to a route; `replace`: without a step that the back button would undo. */
export function go(hash: string, replace = false): void {
  if (replace) {
    history.replaceState(history.state, "", hash); // the same step of the history
    dispatchEvent(new HashChangeEvent("hashchange"));
  } else {
    location.hash = hash;
  }
}
