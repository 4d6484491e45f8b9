// The end of a session: everything is stored, or given to the person as a file.

import { button, make, paragraphs, pause } from "./make.js";
import { download } from "./opening.js";

const AGAIN_MS = 2000;

export async function endSession({ study, display, server, sessions, fault }, session, answers) {
  const heading = make("h1", { text: "Almost done", tabindex: -1 });
  const state = make("p", { role: "status", text: "Your answers are being stored\u2026" });
  display.replaceChildren(heading, state);
  heading.focus();
  if (server !== null) {
    await finished(server, session, answers, fault);
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

/** When nothing waits any more and the server misses none; asked again and again until then. */
async function finished(server, session, answers, fault) {
  let again = false; // whether all was sent a second time
  for (;;) {
    try {
      await answers.sent();
      await server.finish(session);
      fault("");
      return;
    } catch (error) {
      if (error.status === 409 && !again) {
        // a server whose file was put back to an earlier state: what this browser has goes there again
        again = true;
        await answers.sendAgain();
        continue;
      }
      fault(`${error.message} It is tried again.`);
    }
    await pause(AGAIN_MS);
  }
}
