// End of a session: all answers are stored on the server or offered as a file.

import { button, make, paragraphs, pause } from "./make.js";
import { download } from "./session_start.js";

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
    state.textContent = `All ${answers.done.size} answers are stored in this browser.`;
    state.after(save);
  }
  await sessions.end(session);
  heading.textContent = "Thank you";
  heading.after(...paragraphs(study.text.end));
}

/** Send all answers and finish the session; repeat until the server confirms. */
async function finished(server, session, answers, fault) {
  let again = false; // all rows were sent again
  for (;;) {
    try {
      await answers.sent();
      await server.finish(session);
      fault("");
      return;
    } catch (error) {
      if (error.status === 409 && !again) {
        // the server lost rows, for example after its file was restored: send all rows again
        again = true;
        await answers.sendAgain();
        continue;
      }
      fault(`${error.message}. Trying again.`);
    }
    await pause(AGAIN_MS);
  }
}
