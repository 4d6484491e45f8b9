// The kernel and its memory in JavaScript: what Python's engine and mailbox do for a native one.
//
// It runs in the audio thread, where messages are handled between two blocks, so the rings need no
// atomics. `render` creates no object: bytes are copied word by word, without views or BigInts.

import { DIGEST, ENCODING, L, PARAMETERS, SOURCES } from "./layout.js";

export const { WHOLE, CHANGE } = ENCODING;
const { FILL, DATA, TABLE, INTEGRAL, HEAD } = ENCODING;
/** @type {Record<number, string>} */
const WHAT = { [WHOLE]: "a memory", [CHANGE]: "a change" };

export const AT_ONCE = -1;
const TWO_32 = 4294967296;
const PAGE_BYTES = 65536;
const LARGEST_BLOCK = 2048; // frames
const COLUMNS_A_BLOCK = 16384; // of a surface, so that copying one never makes a block late
export const EVENT_FIELDS = 4; // of a control event: sample time, source, theta2, touching
export const STRIKE_FIELDS = 4; // of a strike: sample, event, torque, level

// what `meters` tells, in its order
export const METERS = Object.freeze([
  "clock", "cursor", "touching", "holder", "torque", "friction", "envelope",
  "peakClick", "peakTactor", "strikes", "late", "rejected", "clamped", "dropped", "resets",
  "limited", "silentSamples", "stillSamples", "changesWaiting",
]);

/**
 * Sample rate (Hz) and channels of encoded bytes; an Error in one line if not of this kind.
 * @param {ArrayBuffer} bytes
 * @param {number} kind
 */
export function checkBytes(bytes, kind) {
  const what = WHAT[kind];
  if (!(bytes instanceof ArrayBuffer) || bytes.byteLength % 8 || bytes.byteLength < 8 * HEAD) {
    throw new Error(`not ${what} of the kernel: ${bytes?.byteLength} bytes`);
  }
  const words = new Int32Array(bytes);
  if (words[0] !== DIGEST[0] || words[1] !== DIGEST[1]) {
    throw new Error(`${what} of another version of the kernel: load the page again`);
  }
  const numbers = new Float64Array(bytes);
  const first = HEAD + 2 * words[3];
  let sound = words[2] === kind && first >= HEAD && first <= numbers.length;
  for (let i = HEAD; sound && i < first; i += 2) {
    const column = numbers[i];
    const coefficient = Number.isInteger(column) && column >= 0 && column < L.COEFFS;
    sound = coefficient || column === L.COMMAND_RELEASE_RETURNS;
  }
  let covered = 0;
  let at = first;
  while (sound && at < numbers.length) {
    const how = words[2 * at];
    const count = words[2 * at + 1];
    const known = how === FILL || how === DATA || how === INTEGRAL;
    sound = count > 0 && (known || (how === TABLE && count % 2 === 0));
    covered += count;
    at += 1 + valuesOf(how, count);
  }
  const whole = kind === WHOLE ? L.TOTAL : L.SLOT_SIZE;
  const complete = covered === whole || (kind === CHANGE && first === numbers.length);
  if (!sound || at !== numbers.length || !complete) {
    throw new Error(`not ${what} of the kernel: damaged, or of another kind`);
  }
  return { sampleRate: numbers[3], channels: numbers[4] };
}

/**
 * The kernel's number of a parameter; an Error in one line if it can't have that value.
 * @param {string} id
 * @param {number} value
 */
export function parameterNumber(id, value) {
  if (!Object.hasOwn(PARAMETERS, id)) {
    throw new Error(`no parameter is called ${id}; known: ${Object.keys(PARAMETERS).join(", ")}`);
  }
  const [number, lowest, highest] = PARAMETERS[/** @type {keyof typeof PARAMETERS} */ (id)];
  if (!(value >= lowest && value <= highest)) {
    throw new Error(`${id} = ${value} is out of range; it is ${lowest} to ${highest}`);
  }
  return number;
}

/**
 * How many values a run has for its columns.
 * @param {number} how
 * @param {number} count
 */
function valuesOf(how, count) {
  if (how === FILL) return 1;
  if (how === INTEGRAL) return 0;
  return how === DATA ? count : count / 2;
}

/** Encoded columns on their way into the memory, in pieces. */
class Copy {
  /** @param {ArrayBuffer} bytes */
  constructor(bytes) {
    this.from = new Int32Array(bytes);
    this.values = new Float64Array(bytes);
    this.told = this.from[3]; // pairs before the runs
    this.at = HEAD + 2 * this.told; // column of the present run
    this.hasRuns = this.at < this.values.length;
    this.target = 0; // column of the memory where it begins
    this.done = 0; // columns of it
    this.copied = 0; // of all
  }

  /**
   * Copy up to `room` columns more; whether that was all.
   * @param {Float64Array} m
   * @param {Int32Array} words
   * @param {number} room
   */
  advance(m, words, room) {
    const { from, values } = this;
    while (room > 0 && this.at < values.length) {
      const how = from[2 * this.at];
      const count = from[2 * this.at + 1];
      const stop = Math.min(count, this.done + room);
      const data = this.at + 1;
      room -= stop - this.done;
      this.copied += stop - this.done;
      if (how === FILL) {
        const low = from[2 * data];
        const high = from[2 * data + 1];
        for (let i = this.target + this.done; i < this.target + stop; i += 1) {
          words[2 * i] = low;
          words[2 * i + 1] = high;
        }
      } else if (how === DATA) {
        for (let i = 2 * this.done; i < 2 * stop; i += 1) {
          words[2 * this.target + i] = from[2 * data + i];
        }
      } else if (how === INTEGRAL) {
        const table = this.target - ENCODING.INTEGRAL_FROM_TABLE;
        for (let i = this.done; i < stop; i += 1) {
          const at = this.target + i;
          const mean = i > 0 ? 0.5 * (m[table + 2 * i] + m[table + 2 * i - 2]) : 0;
          m[at] = i > 0 ? m[at - 1] + mean : 0;
        }
      } else {
        const points = count / 2;
        for (let i = this.done; i < stop; i += 1) {
          const point = i >> 1;
          if ((i & 1) === 0) m[this.target + i] = values[data + point];
          else if (point + 1 < points) {
            m[this.target + i] = values[data + point + 1] - values[data + point];
          } else m[this.target + i] = 0;
        }
      }
      this.done = stop;
      if (stop === count) {
        this.at = data + valuesOf(how, count);
        this.target += count;
        this.done = 0;
      }
    }
    return this.at >= values.length;
  }
}

export class Kernel {
  /**
   * `wasm`: the bytes of kernel.wasm; `image`: those of browser_memory.py's `encode_engine`, which
   * goes on from where it was, or begins anew at a `sampleRate` of another one.
   * @param {BufferSource} wasm
   * @param {ArrayBuffer} image
   * @param {number} [sampleRate]
   */
  constructor(wasm, image, sampleRate = undefined) {
    const { sampleRate: given, channels } = checkBytes(image, WHOLE);
    this.sampleRate = sampleRate ?? given;
    this.channels = channels;
    const instance = new WebAssembly.Instance(new WebAssembly.Module(wasm), {});
    const { memory, render, prepare, change, __heap_base } = /** @type {any} */ (instance.exports);
    this.run = render;
    this.adjust = change;
    this.block = Math.ceil(__heap_base.value / 8) * 8;
    this.out = this.block + 8 * L.TOTAL;
    grow(memory, this.out + 4 * LARGEST_BLOCK * channels);
    this.m = new Float64Array(memory.buffer, this.block, L.TOTAL);
    this.words = new Int32Array(memory.buffer, this.block, 2 * L.TOTAL);
    // in pieces, so that the browser has compiled the copying before the first sample
    const copy = new Copy(image);
    while (!copy.advance(this.m, this.words, COLUMNS_A_BLOCK));
    if (this.sampleRate !== given && prepare(this.block, this.sampleRate) !== 1) {
      throw new Error(`the kernel doesn't run at ${this.sampleRate} Hz with this preset's carrier`);
    }
    this.samples = new Float32Array(memory.buffer, this.out, LARGEST_BLOCK * channels);
    this.dropped = 0;
    /** @type {Copy[]} */
    this.waiting = []; // changes, each a Copy
    this.slot = -1; // where the surface of the first of them goes
  }

  /**
   * An int64 column as a number.
   * @param {number} column
   */
  read(column) {
    return this.words[2 * column + 1] * TWO_32 + (this.words[2 * column] >>> 0);
  }

  /**
   * @param {number} column
   * @param {number} value
   */
  write(column, value) {
    this.words[2 * column] = value | 0;
    this.words[2 * column + 1] = Math.floor(value / TWO_32);
  }

  /**
   * Push hands' events: rows of sample time (-1 = at once), source's number, theta2, touching.
   * @param {ArrayLike<number>} events
   */
  control(events) {
    for (let i = 0; i + EVENT_FIELDS <= events.length; i += EVENT_FIELDS) {
      const source = events[i + 1];
      if (!(Number.isInteger(source) && source >= 0 && source < L.SOURCES)) {
        throw new Error(`no source has the number ${source}; known: ${SOURCES.join(", ")}`);
      }
      const written = this.read(L.RING_WRITTEN + source);
      if (written - this.read(L.RING_READ + source) >= L.RING) {
        this.dropped += 1;
      } else {
        const at = source * L.RING + (written % L.RING);
        this.write(L.RING_TIME + at, events[i]);
        this.m[L.RING_THETA2 + at] = events[i + 2];
        this.write(L.RING_TOUCHING + at, events[i + 3] ? 1 : 0);
        this.write(L.RING_WRITTEN + source, written + 1);
      }
    }
  }

  /**
   * Set a parameter by its number, which glides from sample `stamp` on.
   * @param {number} number
   * @param {number} value
   * @param {number} stamp
   */
  set(number, value, stamp = AT_ONCE) {
    if (this.adjust(this.block, number, value, stamp) !== 1) {
      throw new Error(`parameter ${number} = ${value}: too many wait, or the rate is too low`);
    }
  }

  /**
   * Queue a change of browser_memory.py's `encode_change`: in the order of their coming.
   * @param {ArrayBuffer} bytes
   */
  change(bytes) {
    const { sampleRate } = checkBytes(bytes, CHANGE);
    if (sampleRate !== this.sampleRate) {
      throw new Error(`a change for ${sampleRate} Hz; the kernel runs at ${this.sampleRate} Hz`);
    }
    this.waiting.push(new Copy(bytes));
  }

  /**
   * Take over queued changes, copying up to `room` columns of their surfaces.
   * @param {number} room
   */
  takeChanges(room) {
    while (this.waiting.length > 0) {
      const copy = this.waiting[0];
      if (copy.hasRuns && this.slot < 0) {
        this.slot = this.freeSlot();
        if (this.slot < 0) return;
        copy.target = L.SURFACES + this.slot * L.SLOT_SIZE;
      }
      const before = copy.copied;
      const whole = copy.advance(this.m, this.words, room);
      room -= copy.copied - before;
      if (!whole || !this.hasRoom(copy.told + 1)) return;
      const stamp = copy.values[2];
      for (let i = HEAD; i < HEAD + 2 * copy.told; i += 2) {
        this.tell(copy.values[i], copy.values[i + 1], stamp);
      }
      if (this.slot >= 0) this.tell(L.COMMAND_SURFACE, this.slot, stamp);
      this.slot = -1;
      this.waiting.shift();
    }
  }

  /** @param {number} changes */
  hasRoom(changes) {
    return this.read(L.HOST_WRITTEN) - this.read(L.HOST_READ) + changes <= L.HOST_RING;
  }

  /** A surface slot that neither sounds, fades nor waits, or -1. */
  freeSlot() {
    for (let slot = 0; slot < L.SLOTS; slot += 1) {
      let taken = slot === this.read(L.ACTIVE_SLOT);
      taken ||= this.read(L.FADE_LEFT) > 0 && slot === this.read(L.FADING_SLOT);
      for (let i = this.read(L.HOST_READ); i < this.read(L.HOST_WRITTEN); i += 1) {
        const at = i % L.HOST_RING;
        const waits = this.read(L.HOST_WHAT + at) === L.COMMAND_SURFACE;
        taken ||= waits && this.m[L.HOST_VALUE + at] === slot;
      }
      if (!taken) return slot;
    }
    return -1;
  }

  /**
   * Push one parameter or command.
   * @param {number} what
   * @param {number} value
   * @param {number} stamp
   */
  tell(what, value, stamp) {
    const written = this.read(L.HOST_WRITTEN);
    const at = written % L.HOST_RING;
    this.write(L.HOST_TIME + at, stamp);
    this.write(L.HOST_WHAT + at, what);
    this.m[L.HOST_VALUE + at] = value;
    this.write(L.HOST_WRITTEN, written + 1);
  }

  /**
   * Ask for the device's gain, ceiling (linear) and delay (frames) of each signal; they glide.
   * @param {{ gain: number, ceiling: number, delay: number }[]} signals
   */
  output(signals) {
    signals.forEach(({ gain, ceiling, delay }, signal) => {
      const limited = ceiling < 1 || gain > 1;
      this.m[L.L_WANTED + signal] = gain;
      this.m[L.L_WANTED + L.SIGNALS + signal] = ceiling;
      this.m[L.L_WANTED + 2 * L.SIGNALS + signal] = limited ? 1 : 0;
      this.write(L.L_DELAY_WANTED + signal, delay);
    });
  }

  /** Fade out and end: `render` says when that is done. */
  stop() {
    this.write(L.L_STOP, 1);
  }

  /**
   * Overwrite a block: one Float32Array a channel, all of one length; whether the sound is over.
   * @param {Float32Array[]} outputs
   */
  render(outputs) {
    const frames = outputs[0].length;
    let over = false;
    this.takeChanges(COLUMNS_A_BLOCK);
    for (let start = 0; start < frames; start += LARGEST_BLOCK) {
      const part = Math.min(LARGEST_BLOCK, frames - start);
      over = this.run(this.out, part, this.block) === 1;
      for (let channel = 0; channel < outputs.length; channel += 1) {
        const output = outputs[channel];
        const heard = channel < this.channels;
        for (let i = 0; i < part; i += 1) {
          output[start + i] = heard ? this.samples[i * this.channels + channel] : 0;
        }
      }
    }
    return over;
  }

  /** Float64Array of what `METERS` names; peaks are those since the last look. */
  meters() {
    const { m } = this;
    const holder = this.read(L.HOLDER);
    const told = Float64Array.of(
      this.read(L.CLOCK), m[L.X] / L.CELLS, Number(holder >= 0), holder,
      m[L.M_TORQUE], m[L.M_FRICTION], m[L.M_ENVELOPE],
      m[L.L_PEAK], m[L.L_PEAK + 1], this.read(L.M_STRIKES), this.read(L.M_LATE),
      this.read(L.M_REJECTED), this.read(L.M_CLAMPED), this.dropped, this.read(L.M_RESETS),
      this.read(L.M_LIMITED), this.read(L.M_SILENT), this.read(L.M_STILL), this.waiting.length,
    );
    m[L.L_PEAK] = 0;
    m[L.L_PEAK + 1] = 0;
    return told;
  }

  /** Float64Array of the strikes since the last look: rows of sample, event, torque, level. */
  strikes() {
    const total = this.read(L.M_STRIKES);
    const first = Math.max(this.read(L.STRIKES_READ), total - L.STRIKE_LOG);
    const rows = new Float64Array(STRIKE_FIELDS * (total - first));
    for (let i = first; i < total; i += 1) {
      const at = i % L.STRIKE_LOG;
      rows.set(
        [this.m[L.LOG_TIME + at], this.read(L.LOG_EVENT + at), this.m[L.LOG_TORQUE + at],
          this.m[L.LOG_LEVEL + at]],
        STRIKE_FIELDS * (i - first),
      );
    }
    this.write(L.STRIKES_READ, total);
    return rows;
  }
}

/**
 * @param {WebAssembly.Memory} memory
 * @param {number} bytes
 */
function grow(memory, bytes) {
  const missing = bytes - memory.buffer.byteLength;
  if (missing > 0) memory.grow(Math.ceil(missing / PAGE_BYTES));
}
