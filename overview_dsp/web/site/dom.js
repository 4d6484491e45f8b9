/** @import { Elements } from "../types" */

/**
 * Return the element with an id of the page; throw an Error without one.
 * @template {keyof Elements} Id
 * @param {Id} id
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`the page has no element ${id}`);
  return /** @type {Elements[Id]} */ (element);
}

/**
 * Call a function for each event of a type at an element of the page.
 * @template {keyof HTMLElementEventMap} Type
 * @param {keyof Elements} id
 * @param {Type} type
 * @param {(event: HTMLElementEventMap[Type]) => unknown} act
 */
export function on(id, type, act) {
  const element = /** @type {HTMLElement} */ (byId(id));
  element.addEventListener(type, act);
}

/**
 * Return a new element with some properties and children.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string | boolean>} properties
 * @param {(string | Node)[]} children
 */
export function made(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

/**
 * Return a new button that a function handles.
 * @param {string} className
 * @param {() => unknown} act
 * @param {(string | Node)[]} children
 */
export function button(className, act, ...children) {
  const element = made("button", { type: "button", className }, ...children);
  element.addEventListener("click", act);
  return element;
}

/**
 * Return the drawing context of a canvas; throw an Error without one.
 * @param {HTMLCanvasElement} canvas
 */
export function contextOf(canvas) {
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("this browser has no canvas");
  return context;
}
