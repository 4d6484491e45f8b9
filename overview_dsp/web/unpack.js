// Decompression of the kernel's files; sound_data.py documents the format.

const PREDICTED = 8; // order

/**
 * @param {ArrayBuffer} deflated
 * @returns {Promise<ArrayBuffer>}
 */
export function inflated(deflated) {
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/**
 * @param {ArrayBuffer} packed
 * @returns {Promise<ArrayBuffer>}
 */
export async function unpacked(packed) {
  const bytes = new Uint8Array(await inflated(packed));
  const isPredicted = bytes[0] === PREDICTED;
  const order = isPredicted ? 1 : bytes[0];
  const count = isPredicted ? (bytes.length - 9) / 9 : (bytes.length - 1) / 8;
  const values = new Float64Array(count);
  const words = new Uint32Array(values.buffer);
  const ranks = new Int8Array(bytes.buffer, 1 + 8 * count);
  const step = isPredicted ? new DataView(bytes.buffer, 1 + 9 * count).getFloat64(0, true) : 0;
  // running sums of 64-bit integers, in two 32-bit halves
  const low = new Uint32Array(order + 1);
  const high = new Uint32Array(order + 1);
  for (let i = 0; i < count; i += 1) {
    let at = 1 + i;
    const half = () => {
      let word = 0;
      for (let shift = 0; shift < 32; shift += 8, at += count) word |= bytes[at] << shift;
      return word;
    };
    if (isPredicted) {
      const last = values[i - 1];
      const x = step * ranks[i];
      const found = last * (last / values[i - 2]) * (1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4))));
      if (found > 0 && found < Infinity) values[i] = found;
      [low[0], high[0]] = [words[2 * i], words[2 * i + 1]];
    }
    const first = half();
    const second = half();
    const sign = -(first & 1); // all ones for a negative number
    low[order] = ((first >>> 1) | (second << 31)) ^ sign;
    high[order] = (second >>> 1) ^ sign;
    for (let k = order - 1; k >= 0; k -= 1) {
      const sum = low[k] + low[k + 1];
      low[k] = sum;
      high[k] += high[k + 1] + (sum > 0xffffffff ? 1 : 0);
    }
    words[2 * i] = low[0];
    words[2 * i + 1] = high[0];
  }
  return words.buffer;
}
