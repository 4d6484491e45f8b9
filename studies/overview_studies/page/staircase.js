// Interleaved staircases: each goes down after some right answers in a row, up after a wrong one.

export class Staircases {
  /** `step`: an adaptive step of a list (docs/explanation/study-format.md). */
  constructor({ levels, tracks }) {
    this.last = levels.length - 1;
    this.tracks = tracks.map((track) =>
      ({ ...track, at: track.start, right: 0, reversed: 0, moved: 0 }));
    this.turn = 0;
  }

  get over() {
    return this.tracks.every(isOver);
  }

  /** Index of the level that comes next. */
  next() {
    return this.tracks[this.whose()].at;
  }

  /** What the answer at that level was. */
  tell(right) {
    const whose = this.whose();
    this.turn = (whose + 1) % this.tracks.length;
    const track = this.tracks[whose];
    track.right = right ? track.right + 1 : 0;
    if (right && track.right < track.down) return;
    track.right = 0;
    const move = right ? -1 : 1;
    if (move === -track.moved) track.reversed += 1;
    track.moved = move;
    const step = track.steps[Math.min(track.reversed, track.steps.length - 1)];
    track.at = Math.min(Math.max(track.at + move * step, 0), this.last);
  }

  /** The first track at or after the turn that isn't over. */
  whose() {
    const { length } = this.tracks;
    for (let i = 0; i < length; i += 1) {
      const at = (this.turn + i) % length;
      if (!isOver(this.tracks[at])) return at;
    }
    throw new Error("all staircases are over");
  }
}

const isOver = ({ reversed, reversals }) => reversed >= reversals;
