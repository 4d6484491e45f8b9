// Scores of a match, which the labels of its goals begin with ("1-0 Parris"), on the whole timeline.

/** @import { TimelineEvent, View } from "../types" */

const GOALS = new Set(["goal", "own_goal"]);
const SCORE = /^(\d+)-(\d+)(?!\S)/;

/** Return whether an event is a goal. @param {TimelineEvent} event */
export const isGoal = ({ kind }) => GOALS.has(kind);

/**
 * Set the score after each goal of a whole timeline, and the side (1 or 2) of the team that scored.
 * @param {TimelineEvent[]} events
 */
export function setScores(events) {
  let before = [0, 0];
  for (const event of events.filter(isGoal)) {
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
