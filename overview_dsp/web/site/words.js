// Texts of the page: these are needed for the first picture, and `page_words.js` has all others that scripts
// show or say, except those of a server's features. `index.html` has the texts of its elements.

/** @param {string} from @param {string} to */
export const fromTo = (from, to) => `${from} to ${to}`;
export const NO_DATA = "No data";
export const NOW = "now";
/** @param {string} low @param {string} high */
export const range = (low, high) => `from ${fromTo(low, high)}`;
/** @param {string} span */
export const begins = (span) => `${span} begins`;
/** @param {string} kind */
export const whenZoomed = (kind) => `${kind}, when zoomed`;
export const TRY_AGAIN = "Try again";
/** @param {string} reason */
export const notLoaded = (reason) => `The timeline did not load: ${reason}. `;
export const NO_NETWORK = "there is no network, and this device has not stored the page";
export const NO_ANSWER = "the server doesn't answer: check the network and that `overview` is running";
