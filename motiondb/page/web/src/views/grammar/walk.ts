/** Find a node of a tree from the numbers of the children on the way to it. */

import type { TreeNode } from "./types.ts";

/** The node at the end of a path from the root. */
export function nodeAt(tree: readonly TreeNode[], path: readonly number[]): number {
  const children = tree.map((): number[] => []);
  tree.forEach(({ parent }, i) => parent >= 0 && children[parent]!.push(i));
  return path.reduce((node, child) => children[node]![child]!, 0);
}
