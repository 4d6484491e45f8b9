// The WebAssembly kernel and its memory: parameters, surfaces, control events and meters.
//
// The kernel runs in the audio thread. The browser handles messages between two blocks, so the rings
// need no atomics. `render` creates no object: bytes are copied word by word, without views or BigInts.

import { DIGEST, ENCODING, L, PARAMETERS, SOURCES } from "./layout.js";

export const { WHOLE, CHANGE } = ENCODING;
const { FILL, DATA, TABLE, INTEGRAL, HEAD } = ENCODING;
/** @type {Record<number, string>} */
const KIND_NAMES = { [WHOLE]: "memory image", [CHANGE]: "change" };

export const AT_ONCE = -1;
const TWO_32 = 4294967296;
const PAGE_BYTES = 65536;
const LARGEST_BLOCK = 2048; // frames
const COLUMNS_A_BLOCK = 16384; // per block: copying a surface must not delay the audio
export const EVENT_FIELDS = 4; // sample time, source, theta2, touching
export const STRIKE_FIELDS = 4; // sample, event, torque, level

// the order of the values of `meters`
export const METERS = Object.freeze([
  "clock", "cursor", "touching", "activeInput", "torque", "friction", "envelope",
  "peakClick", "peakTactor", "strikes", "late", "rejected", "clamped", "dropped", "resets",
  "limited", "silentSamples", "stillSamples", "changesWaiting",
]);

/**
 * Return the sample rate (Hz) and channels of encoded bytes; throw an Error if they are invalid.
 * @param {ArrayBuffer} bytes
 * @param {number} kind
 */
export function checkBytes(bytes, kind) {
  const name = KIND_NAMES[kind];
  if (!(bytes instanceof ArrayBuffer) || bytes.byteLength % 8 || bytes.byteLength < 8 * HEAD) {
    throw new Error(`not a valid ${name}: ${bytes?.byteLength} bytes`);
  }
  const words = new Int32Array(bytes);
  if (words[0] !== DIGEST[0] || words[1] !== DIGEST[1]) {
    throw new Error(`${name} is of another kernel version; reload the page`);
  }
  const numbers = new Float64Array(bytes);
  const first = HEAD + 2 * words[3];
  let isValid = words[2] === kind && first >= HEAD && first <= numbers.length;
  for (let i = HEAD; isValid && i < first; i += 2) {
    const column = numbers[i];
    const coefficient = Number.isInteger(column) && column >= 0 && column < L.COEFFS;
    isValid = coefficient || column === L.COMMAND_RELEASE_RETURNS;
  }
  let covered = 0;
  let at = first;
  while (isValid && at < numbers.length) {
    const runKind = words[2 * at];
    const count = words[2 * at + 1];
    const isKnown = runKind === FILL || runKind === DATA || runKind === INTEGRAL;
    isValid = count > 0 && (isKnown || (runKind === TABLE && count % 2 === 0));
    covered += count;
    at += 1 + valuesOf(runKind, count);
  }
  const whole = kind === WHOLE ? L.TOTAL : L.SLOT_SIZE;
  const complete = covered === whole || (kind === CHANGE && first === numbers.length);
  if (!isValid || at !== numbers.length || !complete) {
    throw new Error(`not a valid ${name}: damaged, or another type of file`);
  }
  return { sampleRate: numbers[3], channels: numbers[4] };
}

/**
 * Return the kernel's number of a parameter; throw an Error for an unknown name or invalid value.
 * @param {string} id
 * @param {number} value
 */
export function parameterNumber(id, value) {
  if (!Object.hasOwn(PARAMETERS, id)) {
    throw new Error(`unknown parameter ${id}; must be one of: ${Object.keys(PARAMETERS).join(", ")}`);
  }
  const [number, lowest, highest] = PARAMETERS[/** @type {keyof typeof PARAMETERS} */ (id)];
  if (!(value >= lowest && value <= highest)) {
    throw new Error(`${id} = ${value} is out of range; allowed: ${lowest} to ${highest}`);
  }
  return number;
}

/**
 * Return how many values a run stores for its columns.
 * @param {number} runKind
 * @param {number} count
 */
function valuesOf(runKind, count) {
  if (runKind === FILL) return 1;
  if (runKind === INTEGRAL) return 0;
  return runKind === DATA ? count : count / 2;
}

/** Encoded columns, copied into the kernel's memory in pieces. */
class Copy {
  /** @param {ArrayBuffer} bytes */
  constructor(bytes) {
    this.from = new Int32Array(bytes);
    this.values = new Float64Array(bytes);
    this.parameterCount = this.from[3]; // (number, value) pairs before the runs
    this.at = HEAD + 2 * this.parameterCount; // column of the current run
    this.hasRuns = this.at < this.values.length;
    this.target = 0; // first memory column of the current run
    this.done = 0; // columns copied of the current run
    this.copied = 0; // columns copied in total
  }

  /**
   * Copy up to `room` further columns; return whether the copy is complete.
   * @param {Float64Array} numbers
   * @param {Int32Array} words
   * @param {number} room
   */
  advance(numbers, words, room) {
    const { from, values } = this;
    while (room > 0 && this.at < values.length) {
      const runKind = from[2 * this.at];
      const count = from[2 * this.at + 1];
      const stop = Math.min(count, this.done + room);
      const data = this.at + 1;
      room -= stop - this.done;
      this.copied += stop - this.done;
      if (runKind === FILL) {
        const low = from[2 * data];
        const high = from[2 * data + 1];
        for (let i = this.target + this.done; i < this.target + stop; i += 1) {
          words[2 * i] = low;
          words[2 * i + 1] = high;
        }
      } else if (runKind === DATA) {
        for (let i = 2 * this.done; i < 2 * stop; i += 1) {
          words[2 * this.target + i] = from[2 * data + i];
        }
      } else if (runKind === INTEGRAL) {
        const table = this.target - ENCODING.INTEGRAL_FROM_TABLE;
        for (let i = this.done; i < stop; i += 1) {
          const at = this.target + i;
          const mean = i > 0 ? 0.5 * (numbers[table + 2 * i] + numbers[table + 2 * i - 2]) : 0;
          numbers[at] = i > 0 ? numbers[at - 1] + mean : 0;
        }
      } else {
        const points = count / 2;
        for (let i = this.done; i < stop; i += 1) {
          const point = i >> 1;
          if ((i & 1) === 0) numbers[this.target + i] = values[data + point];
          else if (point + 1 < points) {
            numbers[this.target + i] = values[data + point + 1] - values[data + point];
          } else numbers[this.target + i] = 0;
        }
      }
      this.done = stop;
      if (stop === count) {
        this.at = data + valuesOf(runKind, count);
        this.target += count;
        this.done = 0;
      }
    }
    return this.at >= values.length;
  }
}

export class Kernel {
  /**
   * `wasm` holds the bytes of kernel.wasm, `image` those of `encode_engine` (browser_memory.py). The
   * kernel continues from the image's state. At another `sampleRate` it starts from rest.
   * @param {BufferSource} wasm
   * @param {ArrayBuffer} image
   * @param {number} [sampleRate]
   */
  constructor(wasm, image, sampleRate = undefined) {
    const { sampleRate: imageRate, channels } = checkBytes(image, WHOLE);
    this.sampleRate = sampleRate ?? imageRate;
    this.channels = channels;
    const instance = new WebAssembly.Instance(new WebAssembly.Module(wasm), {});
    const { memory, render, prepare, change, __heap_base } = /** @type {any} */ (instance.exports);
    this.renderBlock = render;
    this.setParameter = change;
    this.block = Math.ceil(__heap_base.value / 8) * 8;
    this.out = this.block + 8 * L.TOTAL;
    grow(memory, this.out + 4 * LARGEST_BLOCK * channels);
    this.numbers = new Float64Array(memory.buffer, this.block, L.TOTAL);
    this.words = new Int32Array(memory.buffer, this.block, 2 * L.TOTAL);
    // in pieces: the browser compiles the copy code before the first sample
    const copy = new Copy(image);
    while (!copy.advance(this.numbers, this.words, COLUMNS_A_BLOCK));
    if (this.sampleRate !== imageRate && prepare(this.block, this.sampleRate) !== 1) {
      throw new Error(`${this.sampleRate} Hz is too low for this preset's carrier`);
    }
    this.samples = new Float32Array(memory.buffer, this.out, LARGEST_BLOCK * channels);
    this.dropped = 0;
    /** @type {Copy[]} */
    this.waiting = []; // changes that wait for a free slot
    this.slot = -1; // surface slot that the first change is copied to
  }

  /**
   * Return an int64 column as a number.
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
   * Push control events: rows of sample time (-1: at once), source number, theta2, touching.
   * @param {ArrayLike<number>} events
   */
  control(events) {
    for (let i = 0; i + EVENT_FIELDS <= events.length; i += EVENT_FIELDS) {
      const source = events[i + 1];
      if (!(Number.isInteger(source) && source >= 0 && source < L.SOURCES)) {
        throw new Error(`unknown input ${source}; inputs by number: ${SOURCES.join(", ")}`);
      }
      const written = this.read(L.RING_WRITTEN + source);
      if (written - this.read(L.RING_READ + source) >= L.RING) {
        this.dropped += 1;
      } else {
        const at = source * L.RING + (written % L.RING);
        this.write(L.RING_TIME + at, events[i]);
        this.numbers[L.RING_THETA2 + at] = events[i + 2];
        this.write(L.RING_TOUCHING + at, events[i + 3] ? 1 : 0);
        this.write(L.RING_WRITTEN + source, written + 1);
      }
    }
  }

  /**
   * Set a parameter by its number. The value is smoothed from sample `stamp` on.
   * @param {number} number
   * @param {number} value
   * @param {number} stamp
   */
  set(number, value, stamp = AT_ONCE) {
    if (this.setParameter(this.block, number, value, stamp) !== 1) {
      throw new Error(`parameter ${number} = ${value}: too many pending changes, or the sample rate is too low`);
    }
  }

  /**
   * Queue a change made by `encode_change` (browser_memory.py).
   * @param {ArrayBuffer} bytes
   */
  change(bytes) {
    const { sampleRate } = checkBytes(bytes, CHANGE);
    if (sampleRate !== this.sampleRate) {
      throw new Error(`change is for ${sampleRate} Hz; must be ${this.sampleRate} Hz`);
    }
    this.waiting.push(new Copy(bytes));
  }

  /**
   * Apply queued changes; copy up to `room` columns of their surfaces.
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
      const whole = copy.advance(this.numbers, this.words, room);
      room -= copy.copied - before;
      if (!whole || !this.hasRoom(copy.parameterCount + 1)) return;
      const stamp = copy.values[2];
      for (let i = HEAD; i < HEAD + 2 * copy.parameterCount; i += 2) {
        this.pushCommand(copy.values[i], copy.values[i + 1], stamp);
      }
      if (this.slot >= 0) this.pushCommand(L.COMMAND_SURFACE, this.slot, stamp);
      this.slot = -1;
      this.waiting.shift();
    }
  }

  /** @param {number} changes */
  hasRoom(changes) {
    return this.read(L.HOST_WRITTEN) - this.read(L.HOST_READ) + changes <= L.HOST_RING;
  }

  /** Return a surface slot that is neither active, fading nor queued; -1 if there is none. */
  freeSlot() {
    for (let slot = 0; slot < L.SLOTS; slot += 1) {
      let taken = slot === this.read(L.ACTIVE_SLOT);
      taken ||= this.read(L.FADE_LEFT) > 0 && slot === this.read(L.FADING_SLOT);
      for (let i = this.read(L.HOST_READ); i < this.read(L.HOST_WRITTEN); i += 1) {
        const at = i % L.HOST_RING;
        const waits = this.read(L.HOST_WHAT + at) === L.COMMAND_SURFACE;
        taken ||= waits && this.numbers[L.HOST_VALUE + at] === slot;
      }
      if (!taken) return slot;
    }
    return -1;
  }

  /**
   * Push one parameter or command.
   * @param {number} command
   * @param {number} value
   * @param {number} stamp
   */
  pushCommand(command, value, stamp) {
    const written = this.read(L.HOST_WRITTEN);
    const at = written % L.HOST_RING;
    this.write(L.HOST_TIME + at, stamp);
    this.write(L.HOST_WHAT + at, command);
    this.numbers[L.HOST_VALUE + at] = value;
    this.write(L.HOST_WRITTEN, written + 1);
  }

  /**
   * Set gain, ceiling (linear) and delay (frames) of each signal. The values are smoothed.
   * @param {{ gain: number, ceiling: number, delay: number }[]} signals
   */
  output(signals) {
    signals.forEach(({ gain, ceiling, delay }, signal) => {
      const limited = ceiling < 1 || gain > 1;
      this.numbers[L.L_WANTED + signal] = gain;
      this.numbers[L.L_WANTED + L.SIGNALS + signal] = ceiling;
      this.numbers[L.L_WANTED + 2 * L.SIGNALS + signal] = limited ? 1 : 0;
      this.write(L.L_DELAY_WANTED + signal, delay);
    });
  }

  /** Fade out and end; `render` returns true when the fade is complete. */
  stop() {
    this.write(L.L_STOP, 1);
  }

  /**
   * Render one block into one Float32Array per channel, all of one length; return whether playback has ended.
   * @param {Float32Array[]} outputs
   */
  render(outputs) {
    const frames = outputs[0].length;
    let over = false;
    this.takeChanges(COLUMNS_A_BLOCK);
    for (let start = 0; start < frames; start += LARGEST_BLOCK) {
      const part = Math.min(LARGEST_BLOCK, frames - start);
      over = this.renderBlock(this.out, part, this.block) === 1;
      for (let channel = 0; channel < outputs.length; channel += 1) {
        const output = outputs[channel];
        const isPlayed = channel < this.channels;
        for (let i = 0; i < part; i += 1) {
          output[start + i] = isPlayed ? this.samples[i * this.channels + channel] : 0;
        }
      }
    }
    return over;
  }

  /** Return the values that `METERS` names, as a Float64Array; peaks are reset. */
  meters() {
    const { numbers } = this;
    const activeInput = this.read(L.HOLDER);
    const values = Float64Array.of(
      this.read(L.CLOCK), numbers[L.X] / L.CELLS, Number(activeInput >= 0), activeInput,
      numbers[L.M_TORQUE], numbers[L.M_FRICTION], numbers[L.M_ENVELOPE],
      numbers[L.L_PEAK], numbers[L.L_PEAK + 1], this.read(L.M_STRIKES), this.read(L.M_LATE),
      this.read(L.M_REJECTED), this.read(L.M_CLAMPED), this.dropped, this.read(L.M_RESETS),
      this.read(L.M_LIMITED), this.read(L.M_SILENT), this.read(L.M_STILL), this.waiting.length,
    );
    numbers[L.L_PEAK] = 0;
    numbers[L.L_PEAK + 1] = 0;
    return values;
  }

  /** Return the strikes since the last call: rows of sample, event, torque, level. */
  strikes() {
    const total = this.read(L.M_STRIKES);
    const first = Math.max(this.read(L.STRIKES_READ), total - L.STRIKE_LOG);
    const rows = new Float64Array(STRIKE_FIELDS * (total - first));
    for (let i = first; i < total; i += 1) {
      const at = i % L.STRIKE_LOG;
      rows.set(
        [this.numbers[L.LOG_TIME + at], this.read(L.LOG_EVENT + at), this.numbers[L.LOG_TORQUE + at],
          this.numbers[L.LOG_LEVEL + at]],
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
