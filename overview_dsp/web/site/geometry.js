// Where everything lies in the picture, in CSS pixels.

const WIDE = 760;
const LOW = 300; // no room for the disk

/** Boxes of the curve, the disk and the trace in a picture of `width` by `height`. */
export function geometryOf(width, height, still) {
  const side = width >= WIDE ? 26 : 20;
  const left = side;
  const right = width - side;
  const bare = still || height < LOW;
  const axis = 26;
  const top = 26;
  const bottom = bare ? height - axis - 28 : Math.round(height * (width >= WIDE ? 0.55 : 0.46));
  const made = {
    width, height, left, right, top, bottom, axis, disk: null, trace: null,
    x: (place) => left + (right - left) * place,
    y: (level) => bottom - (bottom - top) * level * 0.92,
    place: (x) => Math.min(Math.max((x - left) / (right - left), 0), 1),
  };
  if (bare) return made;
  const from = bottom + axis + 18;
  const room = height - 34 - from;
  if (width >= WIDE) {
    const radius = Math.min(room / 2 - 8, 150);
    const x = left + radius + 60;
    made.disk = { x, y: from + room / 2 + 4, radius };
    made.trace = { left: x + radius + 90, right, y: from + room / 2, half: room / 2 - 24 };
  } else {
    const half = Math.min(30, room * 0.12);
    const radius = Math.min((room - 2 * half - 26) / 2, width * 0.33);
    made.disk = { x: width / 2, y: from + radius + 4, radius };
    made.trace = { left, right, y: height - 42 - half, half };
  }
  return made;
}

/** The angle on the disk of a place: the start at nine o'clock, over the top, the end at three. */
export function angleOf(place) {
  return Math.PI * (1 + place);
}
