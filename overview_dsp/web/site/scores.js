// Scores of a match on the whole timeline.

/** @import { Info, TimelineEvent, View } from "../types" */

const GOALS = new Set(["goal", "own_goal"]);

/** Return whether an event is a goal. @param {TimelineEvent} event */
export const isGoal = ({ kind }) => GOALS.has(kind);

/**
 * Return the label of an event without the score of a goal.
 * @param {Pick<TimelineEvent, "label" | "score">} event
 */
export function nameOf({ label, score }) {
  const start = score ? `${score.replace("\u2013", "-")} ` : "";
  return label.startsWith(start) ? label.slice(start.length) : label;
}

/**
 * Write the scores of a whole timeline with a dash, and set the side of goals without sides.
 * @param {TimelineEvent[]} events
 */
export function setScores(events) {
  let before = [0, 0];
  for (const event of events) {
    if (!event.score) continue;
    const after = event.score.split("-").map(Number);
    event.score = after.join("\u2013");
    const rises = after.map((count, i) => count > before[i]);
    if (rises[0] !== rises[1]) event.side = rises[0] ? 1 : 2;
    before = after;
  }
}

/**
 * Set scores and sides of a window's goals as they are on the whole timeline, and the score at its start.
 * @param {View} view
 * @param {TimelineEvent[]} whole events of the whole timeline, with scores
 */
export function copyScores(view, whole) {
  const goals = whole.filter(({ score }) => score);
  for (const event of view.events.filter(isGoal)) {
    const same = goals.find((one) => isSameEvent(one, event));
    event.score = same?.score;
    event.side = same?.side;
  }
  view.score = goals.filter(({ time_s }) => time_s < view.start_s).at(-1)?.score;
}

/**
 * Return whether an event of a window and one of the whole timeline are the same.
 * @param {TimelineEvent} a
 * @param {TimelineEvent} b
 */
export const isSameEvent = (a, b) => a.kind === b.kind && a.label === b.label && Math.abs(a.time_s - b.time_s) < 1e-6;

/**
 * Return a title with spaces for the marks of a file name.
 * @param {string} title
 */
export function readableTitle(title) {
  const [name] = title.split(": ");
  return name.includes(" ") ? title : name.replace(/[-_]+(?=\p{L})/gu, " ") + title.slice(name.length);
}

/**
 * Return the parts of a match's title, "A 2-1 B, final": both names, what is between them, and what follows;
 * null without a match.
 * @param {Pick<Info, "title" | "sides">} info
 */
export function titleParts({ title, sides: [one, two] }) {
  const at = two ? title.indexOf(two, one.length) : -1;
  if (at < 0 || !title.startsWith(one)) return null;
  return { one, two, between: title.slice(one.length, at), rest: title.slice(at + two.length).replace(/^[\s,:;]+/, "") };
}
