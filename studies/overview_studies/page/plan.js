// What is still to be done of a list, from the answers that are there: a page that was closed goes on
// with this.

import { Run } from "./adaptive.js";

const ROUNDS = 3; // of practice, at most
const ASKS = new Set(["form", "trial", "adaptive"]);

const isPractice = ({ type, phase }) => type === "trial" && phase === "practice";

/**
 * What is to come, each one of {screen: step}, {trial: step}, {practice: rounds} (lists of trials:
 * `isWanted` says whether a round comes) and {run}. `answers` is a Map of what is known by id.
 */
export function planOf(steps, answers) {
  const nodes = [];
  const parts = partsOf(steps);
  parts.forEach((part, i) => {
    const { first } = part;
    if (!ASKS.has(first.type)) {
      if (isNeeded(parts, i, answers)) nodes.push({ screen: first });
    } else if (!isOver(part, answers)) {
      if (part.practice) nodes.push({ practice: part.practice });
      else if (first.type === "adaptive") nodes.push({ run: replayed(first, answers) });
      else nodes.push(first.type === "form" ? { screen: first } : { trial: first });
    }
  });
  return nodes;
}

/** Steps, with the practice of a block as one; `next` is the step behind. */
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
  const count = trials[0].criterion === null ? 1 : ROUNDS;
  return Array.from({ length: count }, (_, i) =>
    trials.map((step) => (i === 0 ? step : { ...step, id: `${step.id}-${i + 1}` })));
}

/** Whether nothing of a part that asks is left. */
function isOver({ first, practice, next }, answers) {
  if (first.type === "adaptive") return replayed(first, answers).over;
  if (!practice) return answers.has(first.id);
  if (next?.type === "trial" && answers.has(next.id)) return true; // what it was for has begun
  return !practice.some((round, i) =>
    isWanted(practice, i, answers) && round.some(({ id }) => !answers.has(id)));
}

function replayed(step, answers) {
  const run = new Run(step);
  run.replay((id) => answers.get(id));
  return run;
}

/** Whether a round (from 0) of practice comes: those before were answered, too few of them right. */
export function isWanted(rounds, round, answers) {
  return rounds.slice(0, round).every((before) => {
    const told = before.map(({ id }) => answers.get(id));
    const right = told.filter((one) => one?.correct === true).length;
    return !told.includes(undefined) && right < before[0].criterion * before.length;
  });
}

/** Whether instructions or a break come: something of their block is left; a break only before it. */
function isNeeded(parts, at, answers) {
  const { first: { type, block } } = parts[at];
  const asked = parts.slice(at + 1).filter(({ first }) =>
    ASKS.has(first.type) && first.block === block);
  const left = asked.some((part) => !isOver(part, answers));
  return left && (type !== "break" || !asked.some(({ first, practice }) =>
    (practice ? practice[0] : [first]).some(({ id }) => answers.has(id) || answers.has(`${id}-001`))));
}

/** How many answers a list asks for at most, and how many are there; repeated practice is no more. */
export function progressOf(steps, answers) {
  let [done, total] = [0, 0];
  for (const step of steps) {
    if (step.type === "adaptive") {
      const run = replayed(step, answers);
      total += step.most;
      done += run.over ? step.most : run.count;
    } else if (ASKS.has(step.type)) {
      total += 1;
      done += Number(answers.has(step.id));
    }
  }
  return { done, total };
}
