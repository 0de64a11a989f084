/** Colours of the stage, read from the style tokens; and a colour for every number. */

import * as THREE from "three";

// The shaders work on colours as they are shown; three.js must not convert them.
THREE.ColorManagement.enabled = false;

function token(name: string): THREE.Color {
  const text = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  return new THREE.Color(text || "#888888");
}

/** The colours of the stage in the present scheme, light or dark. */
export function stageColours() {
  return {
    background: token("stage"),
    line: token("stage-line"),
    lineStrong: token("stage-line-strong"),
    shadow: token("stage-shadow"),
    figure: token("figure"),
    figureLit: token("figure-lit"),
    contact: token("contact"),
    court: token("stage-court"),
  };
}

export type StageColours = ReturnType<typeof stageColours>;
