// The page's state in the address: #at=goal:5&play=sweep:10&window=1200:3000&preset=stadium.

/** What the fragment says: at, play, window, preset, each a text or null. */
export function readAddress() {
  const given = new URLSearchParams(location.hash.slice(1));
  const [at, play, window, preset] = ["at", "play", "window", "preset"].map((key) => given.get(key));
  return { at, play, window, preset };
}

/**
 * An address with these, where they are given.
 * @param {Record<string, string | null>} state
 */
export function addressOf(state) {
  const address = new URL(location.href);
  const given = Object.entries(state).filter(([, value]) => value);
  address.hash = given.map(([key, value]) => `${key}=${encodeURI(value)}`).join("&");
  return address.href;
}

/**
 * The moment (s) that `at` names: an event ("goal:5", the fifth), seconds, 67:30; null if none.
 * @param {string | null} at
 * @param {{ kind: string, time_s: number }[]} events
 */
export function momentOf(at, events) {
  if (at === null) return null;
  const clock = at.match(/^(?:(\d+):)?(\d+):(\d+(?:\.\d+)?)$/);
  if (clock) return 3600 * Number(clock[1] ?? 0) + 60 * Number(clock[2]) + Number(clock[3]);
  if (/^\d+(\.\d+)?$/.test(at)) return Number(at);
  const [kind, number = "1"] = at.split(":");
  return events.filter((event) => event.kind === kind)[Number(number) - 1]?.time_s ?? null;
}

/**
 * `at` for an event of a window: its kind and which one of that kind it is.
 * @param {{ kind: string, time_s: number }} event
 * @param {{ kind: string, time_s: number }[]} events
 */
export function nameOf(event, events) {
  const same = events.filter(({ kind }) => kind === event.kind);
  const number = 1 + same.findIndex(({ time_s }) => time_s === event.time_s);
  return number > 0 ? `${event.kind}:${number}` : String(Math.round(event.time_s));
}
