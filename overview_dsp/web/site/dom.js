/**
 * The element of an id, as whatever it is.
 * @param {string} id
 * @returns {any}
 */
export const by = (id) => document.getElementById(id);
