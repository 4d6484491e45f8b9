// The timeline's files beside the page: what is drawn (JSON) and what sounds (bytes for the kernel).

async function get(path) {
  const answer = await fetch(new URL(path, import.meta.url));
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
  return answer;
}

const json = async (path) => (await get(path)).json();
const bytes = async (path) => (await get(path)).arrayBuffer();

export class Data {
  static async open() {
    const data = new Data();
    [data.info, data.first] = await Promise.all([
      json("data/timeline.json"), json("data/window-0.json"),
    ]);
    return data;
  }

  /** What is drawn of window `i`, with its number and ends. */
  async view(i) {
    const drawn = i === 0 ? this.first : await json(`data/window-${i}.json`);
    const { level, start_s, end_s } = this.info.windows[i];
    return { ...drawn, number: i, zoom: level, start_s, end_s };
  }

  /** The kernel's memory at a sample rate, over the whole timeline. */
  memory(rate) {
    return this.sound("0", rate);
  }

  /** A change to window `i`. */
  change(i, rate) {
    return this.sound(i === 0 ? "back" : String(i), rate);
  }

  async sound(name, rate) {
    const [first] = this.info.rates;
    const base = bytes(`sound/${name}.bin`);
    if (rate === first) return base;
    return patched(...(await Promise.all([base, bytes(`sound/${name}-${rate}.patch`)])));
  }
}

/** Bytes with some columns replaced (site_sound.py says how). */
export function patched(base, patch) {
  const words = new Uint32Array(patch);
  if (words[0] === 1) return patch.slice(8);
  const made = new Uint32Array(base.slice(0));
  let at = 2;
  for (let run = 0; run < words[1]; run += 1) {
    const column = words[at];
    const count = words[at + 1];
    made.set(words.subarray(at + 2, at + 2 + 2 * count), 2 * column);
    at += 2 + 2 * count;
  }
  return made.buffer;
}
