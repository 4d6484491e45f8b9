// Flow of a session: jsPsych runs the remaining steps.

import { isWanted, planOf } from "./plan.js";
import { screenPlugin } from "./screen.js";
import { trialPlugin } from "./trial.js";

/** Return the jsPsych timeline of the remaining steps. */
function timelineOf(steps, kit) {
  const { answers } = kit;
  const [trialType, screenType] = [trialPlugin(kit), screenPlugin(kit)];
  const nodeOf = (step) => ({ type: trialType, trial: () => step });
  return planOf(steps, answers.done).flatMap(({ screen, trial, practice, run }) => {
    if (screen) return [{ type: screenType, step: () => screen }];
    if (trial) return [nodeOf(trial)];
    if (run) {
      const next = { ...nodeOf(null), trial: () => run.next(), on_finish: ({ response }) => run.addResponse(response) };
      return [{ timeline: [next], loop_function: () => !run.over }];
    }
    return practice.map((round, i) => {
      const left = round.filter(({ id }) => !answers.has(id));
      const again = { type: screenType, step: () => ({ id: `again-${i}`, type: "instructions", again: true }) };
      return {
        timeline: [...(i > 0 && left.length === round.length ? [again] : []), ...left.map(nodeOf)],
        conditional_function: () => left.length > 0 && isWanted(practice, i, answers.done),
      };
    });
  });
}

/** Run the remaining steps of a list. */
export async function runSteps({ study, display }, { participant, list: number }, { steps }, kit) {
  const timeline = timelineOf(steps, kit);
  if (timeline.length === 0) return;
  display.replaceChildren();
  const jsPsych = /** @type {any} */ (globalThis).initJsPsych({ display_element: display });
  jsPsych.data.addProperties({ participant, list: number, design_sha256: study.design_sha256 });
  await jsPsych.run(timeline);
}
