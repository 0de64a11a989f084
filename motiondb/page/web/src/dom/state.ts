/** The state of a view. */

/**
 * Returns the state; whoever sets one of its values has everything drawn from it: once, when all
 * that is being done is done.
 */
export function makeState<T extends object>(values: T, draw: () => void): T {
  let planned = false;
  const run = (): void => {
    planned = false;
    draw();
  };
  return new Proxy(values, {
    set(target, name, value) {
      if (Reflect.get(target, name) !== value && !planned) {
        planned = true;
        queueMicrotask(run);
      }
      return Reflect.set(target, name, value);
    },
  });
}
