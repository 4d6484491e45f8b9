// Scores of a match on the whole timeline, by the sides of its goals, or else by the labels of the goals, which
// then begin with the score ("1-0 Parris").

/** @import { Info, TimelineEvent, View } from "../types" */

const GOALS = new Set(["goal", "own_goal"]);
const SCORE = /^(\d+)-(\d+)(?!\S)/;

/** Return whether an event is a goal. @param {TimelineEvent} event */
export const isGoal = ({ kind }) => GOALS.has(kind);

/**
 * Set the score after each goal of a whole timeline, and the side of goals without sides.
 * @param {TimelineEvent[]} events
 */
export function setScores(events) {
  let before = [0, 0];
  const goals = events.filter(isGoal);
  if (goals.length > 0 && goals.every(({ side }) => side)) {
    for (const event of goals) {
      before[Number(event.side) - 1] += 1;
      event.score = before.join("\u2013");
    }
    return;
  }
  for (const event of goals) {
    const after = event.label.match(SCORE)?.slice(1).map(Number);
    if (!after) continue;
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
 * Return the parts of a match's title, "A 2-1 B, final": both names, what is between them, and what follows;
 * null without a match.
 * @param {Pick<Info, "title" | "sides">} info
 */
export function titleParts({ title, sides: [one, two] }) {
  const at = two ? title.indexOf(two, one.length) : -1;
  if (at < 0 || !title.startsWith(one)) return null;
  return { one, two, between: title.slice(one.length, at), rest: title.slice(at + two.length).replace(/^[\s,:;]+/, "") };
}
