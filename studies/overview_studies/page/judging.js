// Whether an answer was right, and what a person is told of it.

const JUDGED = new Set(["identify", "count", "compare", "staircase", "quest"]);

/** Whether an answer is right, as the person is told; null where that isn't a matter of yes or no. */
export function judged({ task, correct }, response) {
  return JUDGED.has(task) && correct !== null ? response === correct : null;
}

/** What a person is told of an answer. */
export function told({ task, correct }, { task: { words } }, response, right) {
  const say = (value) => words[value] ?? String(value);
  if (task === "locate") {
    const percent = (place) => `${Math.round(100 * place)} %`;
    const where = correct.length === 0
      ? "There was nothing." : `It was at ${correct.map(percent).join(", ")} of the way.`;
    return response === null ? `${where} You said: nothing.` : `${where} You said ${percent(response)}.`;
  }
  if (right === null) return "Thank you.";
  if (right) return "That was right.";
  if (task === "identify" || task === "count") {
    return `That was ${say(response)}? No: it was ${say(correct)}.`;
  }
  return "That was wrong.";
}
