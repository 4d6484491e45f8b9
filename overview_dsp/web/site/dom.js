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
 * Return the drawing context of a canvas; throw an Error without one.
 * @param {HTMLCanvasElement} canvas
 */
export function contextOf(canvas) {
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("this browser has no canvas");
  return context;
}
