// Let in by a server: the token of the address becomes a cookie, and leaves the address.

export async function enter() {
  const given = location.hash.slice(1).split("&");
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  await ask("session", { method: "POST", headers: { Authorization: `Bearer ${token}` } });
  const rest = given.filter((one) => !one.startsWith("token=")).join("&");
  history.replaceState(null, "", location.pathname + (rest ? `#${rest}` : ""));
}

/**
 * An answer; an Error with the server's own line if it refuses.
 * @param {string} path
 * @param {RequestInit} [options]
 */
export async function ask(path, options) {
  const answer = await fetch(new URL(path, import.meta.url), options).catch(() => {
    throw new Error("nothing answers there: is the network on, and `overview` still running?");
  });
  if (answer.ok) return answer;
  const told = answer.headers.get("content-type")?.startsWith("text/plain");
  const line = told ? (await answer.text()).trim() : "";
  throw new Error(line || `${path}: ${answer.status} ${answer.statusText}`);
}

/**
 * The answer to an object that is posted as JSON.
 * @param {string} path
 * @param {object} given
 */
export const post = (path, given) => ask(path, { method: "POST", body: JSON.stringify(given) });
