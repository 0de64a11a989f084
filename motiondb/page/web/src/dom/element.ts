/** Make elements: `h("button.plain", { on: { click } }, "Play")`. */

export type Child = Node | string | number | null | undefined | false | readonly Child[];

type Listeners = { [K in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[K]) => void };

export interface Attributes {
  class?: string;
  /** Properties of the style, set one by one: the content security policy allows no style attribute. */
  style?: Record<string, string>;
  on?: Listeners;
  [name: string]: unknown;
}

/** A tag, with classes after dots. */
type Tag<Map> = (keyof Map & string) | `${keyof Map & string}.${string}`;
type Made<Map, T extends string> = Map[(T extends `${infer Name}.${string}` ? Name : T) & keyof Map];
type Rest = readonly Child[] | readonly [Attributes, ...Child[]];

/** Make an HTML element with classes, attributes, listeners and children. */
export const h = <T extends Tag<HTMLElementTagNameMap>>(tag: T, ...rest: Rest) =>
  make((name) => document.createElement(name), tag, rest) as Made<HTMLElementTagNameMap, T>;

const SVG = "http://www.w3.org/2000/svg";

/** Make an SVG element. */
export const svg = <T extends Tag<SVGElementTagNameMap>>(tag: T, ...rest: Rest) =>
  make((name) => document.createElementNS(SVG, name) as SVGElement, tag, rest) as Made<
    SVGElementTagNameMap,
    T
  >;

function make(create: (name: string) => HTMLElement | SVGElement, tag: string, rest: Rest): Element {
  const [name, ...classes] = tag.split(".");
  const element = create(name!);
  if (classes.length > 0) element.setAttribute("class", classes.join(" "));
  const [first, ...others] = rest;
  const isChild =
    typeof first !== "object" || first === null || first instanceof Node || Array.isArray(first);
  if (!isChild) setAttributes(element, first as Attributes);
  append(element, isChild ? (rest as readonly Child[]) : (others as Child[]));
  return element;
}

function setAttributes(element: Element & ElementCSSInlineStyle, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "on") {
      for (const [type, listener] of Object.entries(value as Listeners)) {
        element.addEventListener(type, listener as EventListener);
      }
    } else if (name === "style") {
      for (const [property, text] of Object.entries(value as Record<string, string>)) {
        element.style.setProperty(property, text);
      }
    } else if (name === "value" && "value" in element) {
      (element as HTMLInputElement).value = String(value);
    } else if (value === true) {
      element.setAttribute(name, "");
    } else if (value !== false && value !== null && value !== undefined) {
      element.setAttribute(name, String(value));
    }
  }
}

/** Append children; text becomes text nodes, lists are flattened, empty values are left out. */
export function append(parent: Node, children: readonly Child[]): void {
  for (const child of children) {
    if (Array.isArray(child)) append(parent, child as Child[]);
    else if (child instanceof Node) parent.appendChild(child);
    else if (child !== null && child !== undefined && child !== false) {
      parent.appendChild(document.createTextNode(String(child)));
    }
  }
}

/** Replace all children of an element. */
export function fill(parent: Element, ...children: Child[]): void {
  parent.replaceChildren();
  append(parent, children);
}
