// Who takes part: a session that this browser has begun, or a new one.

import { csvOf } from "./csv.js";
import { button, insisted, make, paragraphs } from "./make.js";
import { Answers } from "./answers.js";

const CODE = "[A-Za-z0-9_\\-]{1,32}";

/** What this browser keeps of a study's sessions. */
export class Sessions {
  constructor(kept, { design_sha256: design }) {
    this.kept = kept;
    this.present = `session ${design}`;
    this.past = `past ${design} `;
  }

  /** The one that was begun and isn't over; undefined without one. */
  get() {
    return this.kept.get(this.present);
  }

  put(session) {
    return this.kept.put(this.present, session);
  }

  /** It is over: it stays for the CSV, and another may begin. */
  async end(session) {
    await this.kept.put(this.past + session.session, session);
    await this.kept.remove(this.present);
  }

  /** Those that are over. */
  async ended() {
    return (await this.kept.entries(this.past)).map(([, session]) => session);
  }

  /** The answers of sessions as CSV. */
  async csv(sessions) {
    const rows = await Promise.all(sessions.map(({ session }) =>
      new Answers(this.kept, session, null).rows()));
    return csvOf(sessions.map((session, i) => [session, rows[i]]));
  }
}

/** Give a file to the person. */
export function download(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  make("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/**
 * The session, once the person has begun it: session, list, participant, and `answers` where a server
 * has some. `server` is null in a folder.
 */
export async function openSession(context) {
  const { sessions } = context;
  const found = await sessions.get();
  if (found?.session && (await isBack(context, found))) {
    if (context.server === null) return found;
    const told = await insisted(() => resumed(context, found), context.display, context.fault);
    if (told !== null) return { ...found, ...told };
  }
  return begun(context, found?.session ? undefined : found);
}

/** The session as the server has it; null (said) where it has no such one any more. */
async function resumed({ server, fault }, found) {
  try {
    return await server.resume(found);
  } catch (error) {
    if (error.status !== 403) throw error;
    fault(`Session ${found.session} can't go on: ${error.message}.`);
    return null;
  }
}

/** Whether it is the same person who goes on. */
function isBack({ study, display, sessions, felt, fault }, found) {
  return new Promise((resolve) => {
    const heading = make("h1", { text: "Welcome back", tabindex: -1 });
    const go = button("Go on", () => {
      felt.start().catch((error) => fault(error.message));
      resolve(true);
    }, { class: "done" });
    const other = button("I am somebody else", async () => {
      const line = `End the session of ${found.participant}, and begin another one?`;
      if (!window.confirm(line)) return;
      const waiting = new Answers(sessions.kept, found.session, null);
      if (study.server !== null && (await waiting.rows()).some(([, { sent }]) => !sent)) {
        fault("Answers of that session still wait to be stored: go on with it first.");
        return;
      }
      await sessions.end(found);
      resolve(false);
    });
    display.replaceChildren(heading, make("p", {
      text: `You take part as ${found.participant}. It goes on where it was.`,
    }), go, other);
    heading.focus();
  });
}

/** A new session; `asked` is one that was asked for and never answered. */
function begun(context, asked) {
  const { study, display, fault, say, felt } = context;
  return new Promise((resolve) => {
    const heading = make("h1", { text: study.title, tabindex: -1 });
    const code = make("input", {
      id: "code", type: "text", pattern: CODE, maxlength: 32, autocomplete: "off",
      autocapitalize: "off", spellcheck: "false", value: asked?.participant ?? "",
      "aria-describedby": "code-hint",
    });
    const parts = [make("label", { for: "code", text: "Your code, if you were given one" }), code,
      make("p", { id: "code-hint", class: "note", text: "Letters, digits, - and _; no name." })];
    const number = study.server === null ? listInput(study) : null;
    if (number) parts.push(make("label", { for: "list", text: "List" }), number);
    let busy = false;
    const go = button("Begin", async () => {
      if (busy) return;
      const wrong = [code, number].find((field) => field && !field.checkValidity());
      if (wrong) {
        say(wrong === code ? "A code has letters, digits, - and _." : `A list is 1 to ${study.lists}.`);
        wrong.focus();
        return;
      }
      busy = true;
      felt.start().catch((error) => fault(error.message));
      try {
        resolve(await begin(context, asked, code.value, Number(number?.value)));
      } catch (error) {
        fault(error.message);
        busy = false;
      }
    }, { class: "done" });
    const form = make("form", { class: "items", on: { submit: (event) => {
      event.preventDefault();
      go.click();
    } } }, ...parts);
    display.replaceChildren(heading, ...paragraphs(study.text.welcome), form, go);
    tellEnded(context);
    heading.focus();
  });
}

/** Have a list: of the server, or the one that was chosen. */
async function begin({ sessions, server, fault }, asked, participant, list) {
  fault("");
  if (server === null) {
    const made = {
      session: newId(), list, participant: participant || `p${String(list).padStart(3, "0")}`,
    };
    await sessions.put(made);
    return made;
  }
  // kept before it is asked: where the answer is lost, the same request gets the same list
  const request = asked?.request ?? newId();
  await sessions.put({ request, participant });
  let told;
  try {
    told = await server.begin(request, participant);
  } catch (error) {
    if (error.status === 409) await sessions.kept.remove(sessions.present);
    throw error;
  }
  const { answers, ...session } = told;
  await sessions.put(session);
  return { ...session, answers };
}

function listInput({ lists }) {
  const given = new URLSearchParams(location.search).get("list") ?? "1";
  return make("input", {
    id: "list", type: "number", min: 1, max: lists, step: 1, value: given, required: true,
    inputmode: "numeric",
  });
}

/** Who has been here; without a server, the answers of them. */
async function tellEnded({ study, sessions, display }) {
  const ended = await sessions.ended();
  if (ended.length === 0) return;
  const { participant } = ended.at(-1);
  const line = `${participant} has finished in this browser: begin if you are somebody else.`;
  display.append(make("p", { class: "note", text: line }));
  if (study.server !== null) return;
  display.append(button("Download all answers of this browser (CSV)", async () => {
    download(`${study.name}.csv`, await sessions.csv(ended));
  }));
}

/** 32 hexadecimal digits. */
function newId() {
  const octets = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(octets, (octet) => octet.toString(16).padStart(2, "0")).join("");
}
