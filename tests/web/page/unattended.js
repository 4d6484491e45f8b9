// One of `probe.js`'s functions for a browser that nothing drives: the answer is posted.

import * as probe from "/probe.js";

const { name, given } = await (await fetch("/given/job")).json();
let answer;
try {
  answer = { value: await probe[name](...given) };
} catch (error) {
  answer = { error: error.message };
}
await fetch("/answer", { method: "POST", body: JSON.stringify(answer) });
