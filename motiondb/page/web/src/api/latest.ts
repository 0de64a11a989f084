/** Of the questions for one place of a view, the last one counts. */

/**
 * Returns a function that waits for an answer. Where another was asked for meanwhile it throws an
 * abort, which the page does not tell anybody: what stands behind the question does not happen.
 * Asked for nothing, it drops the question before.
 */
export function makeLatest(): <T>(asked?: Promise<T>) => Promise<T> {
  let last: unknown = null;
  return async (asked) => {
    last = asked;
    const [answer] = await Promise.allSettled([asked]);
    if (last !== asked) throw new DOMException("Another question was asked.", "AbortError");
    if (answer.status === "rejected") throw answer.reason;
    return answer.value!;
  };
}
