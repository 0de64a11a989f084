/** Requests to the server, and its errors as sentences for people. */

import { onPage } from "./advice.ts";
import type { Deleted, ErrorReply, Got, Posted, Put } from "./types.ts";

/** Why the server refused a request, or could not be reached. */
export class ApiError extends Error {
  constructor(
    readonly kind: string,
    message: string,
    readonly status: number,
  ) {
    super(message);
  }
}

export type Parameters = Record<string, string | number | boolean | null | undefined | readonly string[]>;

/** A path with parameters; those without a value are left out. */
export function withParameters(path: string, parameters: Parameters): string {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    if (value === null || value === undefined || value === "") continue;
    if (Array.isArray(value)) for (const one of value as string[]) query.append(name, one);
    else query.set(name, String(value));
  }
  const text = query.toString();
  return text ? `${path}?${text}` : path;
}

/** The kind of the fault that the server cannot be reached. */
export const UNREACHABLE = "Unreachable";
const NO_ANSWER =
  "The server does not answer. It may have been stopped: start `motiondb serve` again; this page goes on by itself.";

/** Send a request; a database held by another process is waited for (up to `HELD_TRIES` seconds). */
const HELD_TRIES = 5;

async function send(path: string, init: RequestInit, tries = HELD_TRIES): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch (fault) {
    if (fault instanceof DOMException && fault.name === "AbortError") throw fault;
    throw new ApiError(UNREACHABLE, NO_ANSWER, 0);
  }
  if (response.ok) return response;
  if (response.status === 503 && tries > 0 && !init.signal?.aborted) {
    await new Promise((resolve) => setTimeout(resolve, 1000));
    return send(path, init, tries - 1);
  }
  throw await errorOf(response);
}

async function errorOf(response: Response): Promise<ApiError> {
  try {
    const { error } = (await response.json()) as ErrorReply;
    return new ApiError(error.kind, onPage(error.message), response.status);
  } catch {
    return new ApiError(
      "HTTP",
      `The server answered ${response.status} ${response.statusText}.`,
      response.status,
    );
  }
}

function withBody(method: string, body: unknown): RequestInit {
  return { method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
}

/** Answers that were asked for before the view that shows them was open. */
const early = new Map<string, Promise<unknown>>();

/** Ask now for what the next view asks for; ends when the answer is there, or cannot be. */
export async function prefetch(path: keyof Got, parameters: Parameters): Promise<void> {
  const asked = get(path, parameters);
  early.clear();
  early.set(withParameters(path, parameters), asked);
  await asked.catch(() => undefined); // the view tells it
}

/** Forget answers that were asked for early: the view does not come, or the database has changed. */
export const dropEarly = (): void => early.clear();

/** Request JSON. */
export async function get<P extends keyof Got>(
  path: P,
  parameters: Parameters = {},
  signal?: AbortSignal,
): Promise<Got[P]> {
  const address = withParameters(path, parameters);
  const known = early.get(address);
  if (early.delete(address)) {
    const reply = (await known) as Got[P];
    signal?.throwIfAborted();
    return reply;
  }
  return (await send(address, signal ? { signal } : {})).json();
}

export async function post<P extends keyof Posted>(path: P, body: unknown): Promise<Posted[P]> {
  return (await send(path, withBody("POST", body))).json();
}

export async function put<P extends keyof Put>(path: P, body: unknown): Promise<Put[P]> {
  return (await send(path, withBody("PUT", body))).json();
}

export async function remove<P extends keyof Deleted>(
  path: P,
  parameters: Parameters = {},
): Promise<Deleted[P]> {
  return (await send(withParameters(path, parameters), { method: "DELETE" })).json();
}

/** Request bytes. */
export async function bytes(path: string, parameters: Parameters = {}): Promise<ArrayBuffer> {
  return (await send(withParameters(path, parameters), {})).arrayBuffer();
}

export async function postForBytes(path: string, body: unknown): Promise<ArrayBuffer> {
  return (await send(path, withBody("POST", body))).arrayBuffer();
}

export async function postForm<P extends keyof Posted>(path: P, form: FormData): Promise<Posted[P]> {
  return (await send(path, { method: "POST", body: form })).json();
}

/** Request a file to save, with the name that the server gives it. */
export async function postForFile(path: string, body: unknown): Promise<{ name: string; blob: Blob }> {
  const response = await send(path, withBody("POST", body));
  const disposition = response.headers.get("Content-Disposition") ?? "";
  const name = /filename="?([^";]+)"?/.exec(disposition)?.[1] ?? "motiondb-download";
  return { name, blob: await response.blob() };
}

/** The message to show for anything that was thrown. */
export function messageOf(fault: unknown): string {
  if (fault instanceof Error) return fault.message;
  return String(fault);
}

export function isAbort(fault: unknown): boolean {
  return fault instanceof DOMException && fault.name === "AbortError";
}
