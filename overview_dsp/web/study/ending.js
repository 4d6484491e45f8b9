// The end of a session: everything is stored, or given to the person as a file.

import { button, insisted, make, paragraphs } from "./make.js";
import { download } from "./opening.js";

export async function endSession({ study, display, server, sessions, fault }, session, answers) {
  const heading = make("h1", { text: "Almost done", tabindex: -1 });
  const state = make("p", { role: "status", text: "Your answers are being stored\u2026" });
  display.replaceChildren(heading, state);
  heading.focus();
  if (server !== null) {
    await insisted(() => finished(server, session, answers), display, fault);
    state.textContent = `All ${answers.done.size} answers are stored. You may close this page.`;
  } else {
    const save = button("Download the answers (CSV)", async () => {
      download(`${study.name}_${session.participant}.csv`, await sessions.csv([session]));
    }, { class: "done" });
    state.textContent = `All ${answers.done.size} answers are kept in this browser.`;
    state.after(save);
  }
  await sessions.end(session);
  heading.textContent = "Thank you";
  heading.after(...paragraphs(study.text.end));
}

/** Nothing waits any more, and the server misses none. */
async function finished(server, session, answers) {
  await answers.sent();
  try {
    await server.finish(session);
  } catch (error) {
    if (error.status !== 409) throw error;
    // a server whose file was put back to an earlier state: what this browser has goes there again
    if ((await answers.sendAgain()) === 0) throw error;
    await answers.sent();
    await server.finish(session);
  }
}
