// Requests to a study's server or host. Only authentication is repeated automatically.

const TIMEOUT_MS = 15_000; // connections of a stopped server may stay open

const TEMPORARY = new Set([401, 408, 425, 429]);

/** Permanent rejection: the same request would fail again. */
export class Refused extends Error {
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

export class Server {
  /** `token`: from the address, or null. */
  constructor(token, ask = (path, options) => fetch(path, options)) {
    this.token = token;
    this.sessions = ""; // path of sessions, from study.json
    this.ask = ask;
  }

  /** Authenticate with the token. */
  async enter() {
    const headers = { Authorization: `Bearer ${this.token}` };
    const answer = await this.fetched("session", { method: "POST", headers });
    if (!answer.ok) await refuse(answer, "session");
  }

  /** Fetch a file of the folder. */
  async file(path) {
    const answer = await this.inside(path, {});
    if (!answer.ok) await refuse(answer, path);
    return answer;
  }

  /** Start a session; a repeated `request` returns the same session. */
  begin(request, participant) {
    return this.json("POST", this.sessions, { request, ...(participant ? { participant } : {}) });
  }

  /** Return the session with its stored answers. */
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
    const options = {
      method,
      headers: secret === null ? {} : { "X-Study-Secret": secret },
      ...(body === undefined ? {} : { body: JSON.stringify(body) }),
    };
    const answer = await this.inside(path, options);
    if (!answer.ok) await refuse(answer, path);
    return answer.json();
  }

  /** Send a request; authenticate again if the server has lost the login. */
  async inside(path, options) {
    const answer = await this.fetched(path, options);
    if (answer.status !== 401 || this.token === null) return answer;
    await this.enter();
    return this.fetched(path, options);
  }

  async fetched(path, options) {
    try {
      return await this.ask(path, { ...options, signal: AbortSignal.timeout(TIMEOUT_MS) });
    } catch {
      throw new Error("the server does not respond; check the network");
    }
  }
}

/** Throw an Error with the server's message, or a Refused for a permanent rejection. */
async function refuse(answer, path) {
  const { status, statusText } = answer;
  const isText = answer.headers.get("content-type")?.startsWith("text/plain");
  const line = (isText && (await answer.text()).trim()) || `${path}: ${status} ${statusText}`;
  if (status >= 500 || TEMPORARY.has(status)) throw new Error(line);
  throw new Refused(line, status);
}
