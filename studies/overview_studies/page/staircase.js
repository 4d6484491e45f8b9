// Interleaved staircases: down after several correct answers in a row, up after a wrong one.

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

  /** Return the index of the next level. */
  next() {
    return this.tracks[this.activeTrack()].at;
  }

  /** Record whether the answer at that level was correct. */
  addResponse(right) {
    const index = this.activeTrack();
    this.turn = (index + 1) % this.tracks.length;
    const track = this.tracks[index];
    track.right = right ? track.right + 1 : 0;
    if (right && track.right < track.down) return;
    track.right = 0;
    const move = right ? -1 : 1;
    if (move === -track.moved) track.reversed += 1;
    track.moved = move;
    const step = track.steps[Math.min(track.reversed, track.steps.length - 1)];
    track.at = Math.min(Math.max(track.at + move * step, 0), this.last);
  }

  /** Return the index of the first unfinished track at or after `turn`. */
  activeTrack() {
    const { length } = this.tracks;
    for (let i = 0; i < length; i += 1) {
      const at = (this.turn + i) % length;
      if (!isOver(this.tracks[at])) return at;
    }
    throw new Error("all staircases are over");
  }
}

const isOver = ({ reversed, reversals }) => reversed >= reversals;
