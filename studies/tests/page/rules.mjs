// What a page does with adaptive steps and the control condition, for a comparison with Python:
// JSON in, JSON out.

import { readFileSync } from "node:fs";
import { Run } from "../../overview_studies/page/adaptive.js";
import { StaticMapping } from "../../overview_studies/page/static_mapping.js";

const { runs = [], mapped = [] } = JSON.parse(readFileSync(0, "utf8"));

/** The trials of a step whose answers are correct as `rights` says, and whether the run is over. */
function trialsOf({ step, rights }) {
  const run = new Run(step);
  const trials = [];
  for (const right of rights) {
    if (run.over) break;
    const next = run.next();
    trials.push([next.id, next.phase, next.stimulus, next.correct]);
    run.addResponse(right ? next.correct : 1 - next.correct);
  }
  // a page that was closed goes on where it was
  const again = new Run(step);
  const known = new Map(trials.map(([id, , , correct], i) => [id, { response: rights[i] ? correct : 1 - correct }]));
  again.replay((id) => known.get(id));
  if (again.count !== run.count) throw new Error("another place after a reload");
  if (!run.over && again.next().stimulus !== run.next().stimulus) throw new Error("another level");
  return { trials, over: run.over };
}

/** Samples of events (rows of sample, source, theta2, touching) in blocks of any size. */
function samplesOf({ data, events, frames, block }) {
  const mapping = new StaticMapping(data);
  mapping.control(Float64Array.from(events.flat()));
  const [click, tactor] = [new Float32Array(frames), new Float32Array(frames)];
  for (let at = 0; at < frames; at += block) {
    const end = Math.min(at + block, frames);
    mapping.render(click.subarray(at, end), tactor.subarray(at, end));
  }
  const words = (samples) => Buffer.from(samples.buffer).toString("base64");
  return { click: words(click), tactor: words(tactor), applied: mapping.applied };
}

console.log(JSON.stringify({ runs: runs.map(trialsOf), mapped: mapped.map(samplesOf) }));
