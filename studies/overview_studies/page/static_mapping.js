// Control condition without a disk: the input position sets the vibration amplitude at any speed, and
// events click when passed. docs/explanation/study-format.md describes each step. The Python version
// is bit-identical. No object is allocated per sample.

const COLUMNS = 1024;
const VOICES = 1024; // waves that may sound at once

export class StaticMapping {
  /** `data`: a stimulus's `static-RATE.json`. */
  constructor({ rate, ramp, amplitude, carrier, clicks, waves, ceiling }) {
    this.rate = rate;
    this.ramp = ramp;
    this.amplitude = Float64Array.from(amplitude);
    this.carrier = Float64Array.from(carrier);
    this.places = Float64Array.from(clicks, ({ place }) => place);
    this.waveOf = clicks.map(({ wave }) => wave);
    this.waves = waves.map((wave) => Float64Array.from(wave));
    this.ceiling = ceiling;
    this.clock = 0; // rendered samples
    this.cursor = this.from = this.to = 0;
    this.gain = this.gainFrom = this.gainTo = 0;
    this.k = ramp;
    this.voiceWave = new Int32Array(VOICES).fill(-1);
    this.voiceAt = new Int32Array(VOICES);
    this.voices = 0;
    this.level = 0; // current amplitude of the tactor
    this.pending = []; // pending events, in order: [sample, theta2, touching, source]
    this.applied = []; // applied events with their sample
  }

  /** Add events: rows of sample (-1: immediately), source, theta2, touching. */
  control(rows) {
    for (let i = 0; i + 4 <= rows.length; i += 4) {
      const sample = Math.max(rows[i], this.clock);
      let at = this.pending.length;
      while (at > 0 && this.pending[at - 1][0] > sample) at -= 1;
      this.pending.splice(at, 0, [sample, rows[i + 2], rows[i + 3], rows[i + 1]]);
    }
  }

  /** Overwrite a block of click and tactor samples. */
  render(click, tactor) {
    for (let i = 0; i < click.length; i += 1) {
      while (this.pending.length > 0 && this.pending[0][0] <= this.clock) this.apply();
      tactor[i] = this.step();
      click[i] = this.mixClicks();
      this.clock += 1;
    }
  }

  apply() {
    const [, theta2, touching, source] = this.pending.shift();
    this.applied.push([this.clock, theta2, touching, source]);
    const position = theta2 / Math.PI;
    if (this.gainTo === 1) this.from = this.cursor;
    else this.cursor = this.from = position;
    this.to = position;
    this.gainFrom = this.gain;
    this.gainTo = touching ? 1 : 0;
    this.k = 0;
  }

  /** Advance by one sample; return the tactor sample. */
  step() {
    const before = this.cursor;
    if (this.k < this.ramp) {
      this.k += 1;
      const part = this.k / this.ramp;
      this.cursor = this.from + (this.to - this.from) * part;
      this.gain = this.gainFrom + (this.gainTo - this.gainFrom) * part;
    }
    if (this.gainTo === 1) this.pass(before, this.cursor);
    const x = this.cursor * COLUMNS;
    const i = Math.min(Math.floor(x), COLUMNS - 1);
    const a = this.amplitude[i] + (this.amplitude[i + 1] - this.amplitude[i]) * (x - i);
    this.level = this.gain * a;
    return this.gain * a * this.carrier[this.clock % this.carrier.length];
  }

  /** Start the clicks between two positions. */
  pass(from, to) {
    if (from === to) return;
    for (let j = 0; j < this.places.length; j += 1) {
      const place = this.places[j];
      if ((from < place && place <= to) || (to <= place && place < from)) {
        if (this.voices === VOICES) this.drop(0);
        this.voiceWave[this.voices] = this.waveOf[j];
        this.voiceAt[this.voices] = 0;
        this.voices += 1;
      }
    }
  }

  /** Return the sum of all active waves, in order of onset. */
  mixClicks() {
    let sum = 0;
    for (let v = 0; v < this.voices; v += 1) {
      const wave = this.waves[this.voiceWave[v]];
      sum += wave[this.voiceAt[v]];
      this.voiceAt[v] += 1;
    }
    for (let v = this.voices - 1; v >= 0; v -= 1) {
      if (this.voiceAt[v] >= this.waves[this.voiceWave[v]].length) this.drop(v);
    }
    return Math.min(Math.max(sum, -this.ceiling), this.ceiling);
  }

  drop(v) {
    this.voiceWave.copyWithin(v, v + 1, this.voices);
    this.voiceAt.copyWithin(v, v + 1, this.voices);
    this.voices -= 1;
  }
}
