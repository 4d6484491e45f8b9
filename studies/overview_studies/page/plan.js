// Remaining steps of a list, from the stored answers. A reloaded page resumes with them.

import { Run } from "./adaptive.js";

const MAX_PRACTICE_ROUNDS = 3;
const ANSWERED = new Set(["form", "trial", "adaptive"]);

const isPractice = ({ type, phase }) => type === "trial" && phase === "practice";

/**
 * Return the remaining nodes: {screen: step}, {trial: step}, {practice: rounds} or {run}. Rounds are
 * lists of trials; `isWanted` decides whether a round is needed. `answers` is a Map of results by id.
 */
export function planOf(steps, answers) {
  const nodes = [];
  const parts = partsOf(steps);
  parts.forEach((part, i) => {
    const { first } = part;
    if (!ANSWERED.has(first.type)) {
      if (isNeeded(parts, i, answers)) nodes.push({ screen: first });
    } else if (!isOver(part, answers)) {
      if (part.practice) nodes.push({ practice: part.practice });
      else if (first.type === "adaptive") nodes.push({ run: replayed(first, answers) });
      else nodes.push(first.type === "form" ? { screen: first } : { trial: first });
    }
  });
  return nodes;
}

/** Return the steps, with the practice of a block as one part; `next` is the following step. */
function partsOf(steps) {
  const parts = [];
  for (let i = 0; i < steps.length; i += 1) {
    const first = steps[i];
    let end = i + 1;
    if (isPractice(first)) {
      while (end < steps.length && isPractice(steps[end])) end += 1;
      parts.push({ first, practice: roundsOf(steps.slice(i, end)), next: steps[end] });
    } else {
      parts.push({ first, practice: null, next: steps[end] });
    }
    i = end - 1;
  }
  return parts;
}

function roundsOf(trials) {
  const { criterion, rounds = MAX_PRACTICE_ROUNDS } = trials[0];
  const count = criterion === null ? 1 : rounds;
  return Array.from({ length: count }, (_, i) =>
    trials.map((step) => (i === 0 ? step : { ...step, id: `${step.id}-${i + 1}` })));
}

/** Return whether a part is complete. */
function isOver({ first, practice, next }, answers) {
  if (first.type === "adaptive") return replayed(first, answers).over;
  if (!practice) return answers.has(first.id);
  if (next?.type === "trial" && answers.has(next.id)) return true; // main trials have begun
  return !practice.some((round, i) =>
    isWanted(practice, i, answers) && round.some(({ id }) => !answers.has(id)));
}

function replayed(step, answers) {
  const run = new Run(step);
  run.replay((id) => answers.get(id));
  return run;
}

/** Return whether a practice round (from 0) is needed: all earlier rounds failed the criterion. */
export function isWanted(rounds, round, answers) {
  return rounds.slice(0, round).every((before) => {
    const results = before.map(({ id }) => answers.get(id));
    const right = results.filter((one) => one?.correct === true).length;
    return !results.includes(undefined) && right < before[0].criterion * before.length;
  });
}

/** Return whether a screen is needed: steps of the block remain; a break or an example only at its start. */
function isNeeded(parts, at, answers) {
  const { first: { type, block } } = parts[at];
  const answerable = parts.slice(at + 1).filter(({ first }) =>
    ANSWERED.has(first.type) && first.block === block);
  const left = answerable.some((part) => !isOver(part, answers));
  return left && (!["break", "example"].includes(type) || !answerable.some(({ first, practice }) =>
    (practice ? practice[0] : [first]).some(({ id }) => answers.has(id) || answers.has(`${id}-001`))));
}

/** Return the maximum number of answers and the number stored; repeated practice does not count. */
export function progressOf(steps, answers) {
  let [done, total] = [0, 0];
  for (const step of steps) {
    if (step.type === "adaptive") {
      const run = replayed(step, answers);
      total += step.most;
      done += run.over ? step.most : run.count;
    } else if (ANSWERED.has(step.type)) {
      total += 1;
      done += Number(answers.has(step.id));
    }
  }
  return { done, total };
}
