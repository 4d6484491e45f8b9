// Which window comes next: the nearest of another level about a moment, or the one beside.

/** The index of the window of `level` whose middle is nearest to a moment (s); -1 if none. */
export function windowAbout(windows, level, moment) {
  let best = -1;
  let least = Infinity;
  windows.forEach((window, i) => {
    const away = Math.abs((window.start_s + window.end_s) / 2 - moment);
    if (window.level === level && away < least) [best, least] = [i, away];
  });
  return best;
}

/** The window beside window `i`, earlier (-1) or later (1), half of it new; -1 at the ends. */
export function windowBeside(windows, i, direction) {
  const beside = i + direction;
  return windows[beside]?.level === windows[i].level ? beside : -1;
}

export function levels(windows) {
  return windows.at(-1).level;
}
