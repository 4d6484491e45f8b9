// Correctness of answers and the feedback text.

const JUDGED = new Set(["identify", "count", "compare", "staircase", "quest"]);

/** Return whether an answer is correct; null if the task has no single correct answer. */
export function isCorrect({ task, correct }, response) {
  return JUDGED.has(task) && correct !== null ? response === correct : null;
}

/** Return the feedback text for an answer. */
export function feedbackText({ task, correct }, { task: { words } }, response, right) {
  const labelOf = (value) => words[value] ?? String(value);
  if (task === "locate" || task === "search") {
    const percent = (position) => `${Math.round(100 * position)} %`;
    const answer = correct.length === 0
      ? "Correct: nothing there." : `Correct: ${correct.map(percent).join(", ")}.`;
    return response === null ? `Your answer: nothing there. ${answer}` : `Your answer: ${percent(response)}. ${answer}`;
  }
  if (right === null) return "Thank you.";
  if (right) return "Correct.";
  if (task === "identify" || task === "count") {
    return `Your answer: ${labelOf(response)}. Correct: ${labelOf(correct)}.`;
  }
  return "Wrong.";
}
