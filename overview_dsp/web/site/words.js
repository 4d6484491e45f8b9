// A place of a window in words: when it is, and what happened there.

const AT = 0.004; // of the surface: as near is at the event

// made once: one takes longer than all else a frame does
const DAYS = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", day: "numeric", month: "short", year: "numeric",
});
const TIMES = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", weekday: "short", hour: "2-digit", minute: "2-digit", second: "2-digit",
});

/** Minutes and seconds of a timeline, or its date where it has a calendar. */
export function momentText(seconds, info) {
  if (info.start) {
    const zone = info.start.match(/(Z|[+-]\d\d:\d\d)$/)?.[0] ?? "";
    const local = info.start.slice(0, info.start.length - zone.length);
    const moment = new Date(Date.parse(`${local}Z`) + 1e3 * seconds);
    return (info.duration_s > 3 * 86400 ? DAYS : TIMES).format(moment);
  }
  const short = info.duration_s < 120;
  const whole = short ? Math.floor(seconds) : Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  const rest = String(whole % 60).padStart(2, "0");
  const hours = Math.floor(minutes / 60);
  const tenth = short ? `.${Math.floor((seconds - whole) * 10)}` : "";
  if (info.duration_s < 3 * 3600) return `${minutes}:${rest}${tenth}`;
  return `${hours}:${String(minutes % 60).padStart(2, "0")}:${rest}`;
}

/** Kind and label of an event, without saying the kind twice. */
export function eventText(event, info) {
  const words = info.kinds[event.kind]?.words ?? event.kind;
  if (!event.label) return words;
  if (event.label.toLowerCase().includes(words.toLowerCase())) return event.label;
  return `${words}, ${event.label}`;
}

/** The event at a place of a window, or null. */
export function eventAt(view, place) {
  let nearest = null;
  for (const event of view.events) {
    const away = Math.abs(event.place - place);
    if (away <= AT && (!nearest || away < Math.abs(nearest.place - place))) nearest = event;
  }
  return nearest;
}

/** The last event that a disk passed on its way between two places of a window, or null. */
export function eventPassed(view, from, to) {
  const [low, high] = from < to ? [from, to] : [to, from];
  const passed = view.events.filter(({ place }) => place > low && place <= high);
  return (from < to ? passed.at(-1) : passed[0]) ?? null;
}

export function secondsAt(view, place) {
  return view.start_s + (view.end_s - view.start_s) * place;
}

/** What a person who doesn't see is told of a place. */
export function placeText(view, place, info) {
  const moment = momentText(secondsAt(view, place), info);
  const here = eventAt(view, place);
  if (here) return `${moment}, ${eventText(here, info)}`;
  if (view.gaps.some(([from, to]) => place > from && place < to)) return `${moment}, no data`;
  const before = view.events.filter((event) => event.place < place).at(-1);
  return before ? `${moment}, after ${eventText(before, info)}` : moment;
}
