// What the page asks a study's server or host. Nothing here tries again by itself but being let in.

const PATIENCE_MS = 15_000; // a killed server's connection may never say anything

const PASSES = new Set([401, 408, 425, 429]);

/** Asked again, it would be refused again. */
export class Refused extends Error {
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

export class Server {
  /** `token`: of the address, null without one. */
  constructor(token, ask = (path, given) => fetch(path, given)) {
    this.token = token;
    this.sessions = ""; // the path of sessions, of study.json
    this.ask = ask;
  }

  /** Be let in by the token. */
  async enter() {
    const headers = { Authorization: `Bearer ${this.token}` };
    const answer = await this.fetched("session", { method: "POST", headers });
    if (!answer.ok) await refuse(answer, "session");
  }

  /** A file of the folder. */
  async file(path) {
    const answer = await this.inside(path, {});
    if (!answer.ok) await refuse(answer, path);
    return answer;
  }

  /** A list of its own: the same `request` is the same session. */
  begin(request, participant) {
    return this.json("POST", this.sessions, { request, ...(participant ? { participant } : {}) });
  }

  /** The session with what is stored of it. */
  resume({ session, secret }) {
    return this.json("GET", `${this.sessions}/${session}`, undefined, secret);
  }

  store({ session, secret }, id, row) {
    return this.json("PUT", `${this.sessions}/${session}/trials/${id}`, row, secret);
  }

  finish({ session, secret }) {
    return this.json("POST", `${this.sessions}/${session}/finish`, {}, secret);
  }

  async json(method, path, body, secret = null) {
    const given = {
      method,
      headers: secret === null ? {} : { "X-Study-Secret": secret },
      ...(body === undefined ? {} : { body: JSON.stringify(body) }),
    };
    const answer = await this.inside(path, given);
    if (!answer.ok) await refuse(answer, path);
    return answer.json();
  }

  /** An answer, having been let in anew where the server has forgotten that. */
  async inside(path, given) {
    const answer = await this.fetched(path, given);
    if (answer.status !== 401 || this.token === null) return answer;
    await this.enter();
    return this.fetched(path, given);
  }

  async fetched(path, given) {
    try {
      return await this.ask(path, { ...given, signal: AbortSignal.timeout(PATIENCE_MS) });
    } catch {
      throw new Error("nothing answers: is the network on?");
    }
  }
}

/** An Error with the server's own line: a Refused where the same would be refused again. */
async function refuse(answer, path) {
  const { status, statusText } = answer;
  const told = answer.headers.get("content-type")?.startsWith("text/plain");
  const line = (told && (await answer.text()).trim()) || `${path}: ${status} ${statusText}`;
  if (status >= 500 || PASSES.has(status)) throw new Error(line);
  throw new Refused(line, status);
}
