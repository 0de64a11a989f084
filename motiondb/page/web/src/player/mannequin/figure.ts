/** What is loaded after the first pictures: the mannequin for plain canvases. */

export { fits } from "./bones.ts";
export { drawPortrait } from "./portrait.ts";
