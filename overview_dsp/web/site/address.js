// Page state in the URL fragment: #at=goal:5&play=sweep:10&window=1200:3000&preset=stadium. Times and
// numbers of events count on the whole timeline.

/** Return at, play, window and preset of the fragment; each is a string or null. */
export function readAddress() {
  const parameters = new URLSearchParams(location.hash.slice(1));
  const [at, play, window, preset] = ["at", "play", "window", "preset"].map((key) => parameters.get(key));
  return { at, play, window, preset };
}

/**
 * Return the page's URL with these fields in its fragment.
 * @param {Record<string, string | null>} state
 */
export function linkTo(state) {
  const address = new URL(location.href);
  const parameters = Object.entries(state).flatMap(([key, value]) =>
    (value ? [`${key}=${encodeURIComponent(value).replaceAll("%3A", ":")}`] : []));
  address.hash = parameters.join("&");
  return address.href;
}

/**
 * Return the time (s) of an event ("goal:5": the fifth), of seconds, or of 67:30; null if unknown.
 * @param {string} at
 * @param {{ kind: string, time_s: number }[]} events of the whole timeline
 */
export function momentAt(at, events) {
  const clock = at.match(/^(?:(\d+):)?(\d+):(\d+(?:\.\d+)?)$/);
  if (clock) return 3600 * Number(clock[1] ?? 0) + 60 * Number(clock[2]) + Number(clock[3]);
  if (/^\d+(\.\d+)?$/.test(at)) return Number(at);
  const [, kind, number = "1"] = at.match(/^(.*?)(?::(\d+))?$/) ?? [];
  return events.filter((event) => event.kind === kind)[Number(number) - 1]?.time_s ?? null;
}

/**
 * Return the `at` field of an event: its kind and its number within that kind.
 * @param {{ kind: string, time_s: number }} event
 * @param {{ kind: string, time_s: number }[]} events
 */
export function eventName(event, events) {
  const same = events.filter(({ kind }) => kind === event.kind);
  const number = 1 + same.findIndex(({ time_s }) => time_s === event.time_s);
  return number > 0 ? `${event.kind}:${number}` : String(Math.round(event.time_s));
}
