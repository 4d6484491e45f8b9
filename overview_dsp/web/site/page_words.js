// Texts that the page's scripts show or say, beside those of the first picture (`words.js`).

/** @param {number} count */
export const eventCount = (count) => (count === 1 ? "1 event" : `${count} events`);
export const THINNED = "; only some of the values, with all extremes: zoom in for more";
export const SAME_MARKS = "Some kinds have the same mark";
export const STRETCHED = "Spans of the groove last equally long: where they are wider, time is stretched to separate "
  + "close events";

// --- buttons
export const DRAG_HERE = "Drag here";
export const TO_FEEL_IT = " to feel it";
export const PLAY = "Play";
export const PAUSE = "Pause";
export const WATCH = "Watch";
export const SHARE = "Share";
export const SHARED = "Shared";
export const COPIED = "Link copied";
export const THIS_COMPUTER = ", for this computer only";
export const PREVIOUS_EVENT = "Previous event";
export const NEXT_EVENT = "Next event";
export const PREVIOUS_VALUE = "Previous value";
export const NEXT_VALUE = "Next value";
/** @param {number} count */
export const missed = (count) => `Feel what you missed: ${eventCount(count)}`;

// --- announcements
/** @param {number} seconds */
export const playing = (seconds) => `Playing, ${seconds} seconds`;
export const ENDED = "Ended";
export const PAUSED = "Paused";
export const NO_MORE_DETAIL = "No more detail";
export const WHOLE = "The whole timeline";
export const NOTHING_AFTER = "Nothing after this";
export const NOTHING_BEFORE = "Nothing before this";
export const NOTHING_FOUND = "Nothing called that";
/** @param {string} position */
export const tapAt = (position) => `Tap at ${position}`;
export const TWIST_ON = "Twist on: turn the phone";
export const TWIST_OFF = "Twist off";
export const NEW = "new: ";
export const WITHDRAWN = "withdrawn: ";
/** @param {string} kind @param {boolean} isShown @param {number} count */
export const kindShown = (kind, isShown, count) =>
  `${kind} ${isShown ? "shown" : "hidden, still felt"}; ${eventCount(count)} shown`;
export const SILENT = "This browser has no sound output: the disk moves in silence, without friction.";
export const INTERRUPTED = "the sound was interrupted: touch to continue";
export const NO_VIBRATION = "this phone cannot vibrate from a web page; you hear every event";
export const NO_SENSOR = "this browser has no motion sensor";
export const NEEDS_HTTPS = "motion needs a page served over https";
export const MOTION_DENIED = "motion was denied; allow it in the browser's settings for this page";
export const NO_MOTION = "this device reports no motion: drag instead";
/** @param {string} preset @param {string} own */
export const noPreset = (preset, own) =>
  `this page has no preset ${preset}, only ${own}; a page of overview serve has all`;
/** @param {string} window @param {number} end */
export const unknownWindow = (window, end) => `unknown window ${window}; use START:END in seconds, 0 to ${end}`;
/** @param {string} at */
export const unknownPosition = (at) => `unknown position ${at}; use goal:5, 67:30 or seconds`;
/** @param {string} at @param {string} moment @param {string} end */
export const afterEnd = (at, moment, end) => `position ${at} (${moment}) is after the end, ${end}`;
/** @param {string} at @param {string} moment @param {string} window */
export const outsideWindow = (at, moment, window) => `position ${at} (${moment}) is outside of the window, ${window}`;
/** @param {string | null} gesture */
export const unknownGesture = (gesture) => `unknown gesture ${gesture}; use sweep:10 or tap:0.5`;
/** @param {string} address */
export const cannotShare = (address) => `this browser can't share; copy the link: ${address}`;

/** Keys and what they do. */
export const HELP = [
  ["Arrows", "previous and next value or event"],
  ["Shift + arrows, Page keys", "move by a hundredth, by a tenth"],
  ["[ and ]", "previous and next event"],
  [", and .", "previous and next value"],
  ["Home, End", "first, last"],
  ["X, N", "highest, lowest"],
  ["Space, T", "tap: touch and release"],
  ["Escape", "release"],
  ["P", "play or pause"],
  ["+ and \u2212", "zoom"],
  ["E", "list of events"],
  ["V", "watch the film, if there is one"],
  ["H", "this help"],
];
