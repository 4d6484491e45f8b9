// Requests to the server. The token of the URL is exchanged for a cookie and removed from the URL.

import { NO_ANSWER } from "./words.js";

let token = ""; // of the URL that opened this page

/** Return the token that opened this page; "" without one, or after a reload. */
export const accessToken = () => token;

export async function openSession() {
  const fields = location.hash.slice(1).split("&");
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!given) return;
  await request("session", { method: "POST", headers: { Authorization: `Bearer ${given}` } });
  token = given;
  const rest = fields.filter((one) => !one.startsWith("token=")).join("&");
  history.replaceState(null, "", location.pathname + (rest ? `#${rest}` : ""));
}

/**
 * Return a response; throw an Error with the server's message if it fails.
 * @param {string} path
 * @param {RequestInit} [options]
 */
export async function request(path, options) {
  const answer = await fetch(new URL(path, import.meta.url), options).catch(() => {
    throw new Error(NO_ANSWER);
  });
  if (answer.ok) return answer;
  const isText = answer.headers.get("content-type")?.startsWith("text/plain");
  const line = isText ? (await answer.text()).trim() : "";
  throw new Error(line || `${path}: ${answer.status} ${answer.statusText}`);
}

/**
 * Return the response to an object that is posted as JSON.
 * @param {string} path
 * @param {object} body
 */
export const post = (path, body) => request(path, { method: "POST", body: JSON.stringify(body) });
