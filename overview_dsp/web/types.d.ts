// What the page's scripts hand each other. Files of a timeline: site_data.py says what is in them.

import type { Look } from "./kernel_node";

/** One event of a window; `place` 0 to 1 in it. */
export interface TimelineEvent {
  place: number;
  time_s: number;
  kind: string;
  label: string;
}

/** A kind of event: how it is called and drawn, how many there are, a motor's code (ms on, off, ...). */
export interface Kind {
  words: string;
  shape: string;
  colour: string;
  count: number;
  pulse: number[];
}

export interface Ends {
  start_s: number;
  end_s: number;
}

/** A window of the list. */
export interface Window extends Ends {
  level: number;
}

/** A part of the timeline: a window by its number, or any other (number -1). */
export interface Part extends Ends {
  number: number;
  zoom: number;
}

export interface Points {
  time_s: number[];
  value: number[];
}

/** Points of a window's map from moments (s of the timeline) to places; lines between them. */
export interface AngleMap {
  time_s: number[];
  place: number[];
}

/** What is drawn of a part, and said. */
export interface View extends Part {
  /** null where places are proportional to time. */
  map: AngleMap | null;
  level: number[];
  resistance: number[];
  gaps: [number, number][];
  events: TimelineEvent[];
  struck: number[];
  scale: [number, number];
  points: Points | null;
  /** Up to where a timeline that grows has happened, s. */
  now?: number;
}

export interface Series {
  unit: string;
  decimals: number;
  whole: boolean;
  hours: boolean;
}

export interface Media {
  url: string;
  type: string;
  offset_s: number;
}

export interface Server {
  audio: "here" | "host";
  window: [number, number];
  media: Media | null;
}

/** What holds for all windows. */
export interface Info {
  title: string;
  preset: string;
  duration_s: number;
  start: string | null;
  series: Series | null;
  full_torque: number;
  bare_friction: number;
  rates: number[];
  kinds: Record<string, Kind>;
  provenance: string;
  notes: string[];
  windows: Window[];
  server: Server | null;
  live: LiveInfo | null;
}

export interface LiveInfo {
  levels: number;
  version: number;
  poll_s?: number;
}

/** A notice of a timeline that grows (live_data.py). */
export interface Notice {
  version: number;
  words: string;
  news: {
    what: string;
    kind: string;
    label: string;
    time_s: number;
    pulse: number[];
    version: number;
  }[];
  /** The update itself, base64, where it was asked for. */
  update?: string;
}

/** What a page lacks of a timeline that grows. */
export interface Update {
  version: number;
  info: any;
  view: any;
  rate: number;
  bytes: number;
  patch: ArrayBuffer;
}

export type EventKind = Record<string, any> & { points: number[]; modes: Record<string, number>[] };

/** A preset as it travels (serialization.py). */
export interface Preset {
  name: string;
  values: Record<string, any>;
  kinds: Record<string, EventKind>;
  points: number[];
}

/** A row of the parameter table. */
export interface Parameter {
  id: string;
  low: number;
  high: number;
  choices: any[];
  surface: boolean;
  unit: string;
  scale: string;
  doc: string;
}

/** What is drawn by hand: its words, how it is without any points, whether it may be all 0. */
export interface Drawing {
  name: string;
  label: string;
  doc: string;
  back: string;
  plain: (part: number) => number;
  empty: boolean;
}

/** What the sound tells of the disk at a look; a host tells less. */
export type Told = Pick<Look, "cursor" | "touching" | "torque" | "envelope" | "struck"> & Partial<Look>;

/** Sound made here, or a host's. */
export interface SoundFace {
  clock: Clock;
  readonly running: boolean;
  node?: any;
  context?: AudioContext;
  load?: () => Promise<void>;
  start(): void;
  control(place: number, touching: boolean, sample: number): void;
  route(felt: string): void;
  volume(click: number, tactor: number): void;
  show(part: Part): Promise<() => void>;
  feel(before: Preset, after: Preset, part: Part | null): Promise<void>;
  look(): Promise<Told>;
  onstate(sounds: boolean): void;
  call?: (name: string) => void;
}

/** From ms of the page's clock to the samples that strokes are stamped with. */
export interface Clock {
  rate: number;
  sampleAt(time: number): number;
  rendering(time: number): number;
}

/** A host's disk (session.py). */
export interface Status {
  cursor: number;
  touching: boolean;
  torque_nm: number;
  envelope: number;
  window: [number, number];
  round_trip_ms: number | null;
  event_to_sample_ms: number | null;
  output_ms: number;
  others: OtherHand[];
}

export interface OtherHand {
  name: string;
  place: number;
  holding: boolean;
}

export interface Gesture {
  name: string;
  seconds?: number;
  from?: number;
  to?: number;
  place?: number;
}

/** A hand's share in the disk. */
export type Source = "touch" | "twist" | "keys" | "play";

export interface Disk {
  x: number;
  y: number;
  radius: number;
}

export interface TraceBox {
  left: number;
  right: number;
  y: number;
  half: number;
}

/** Where everything lies, in CSS pixels. */
export interface Geometry {
  width: number;
  height: number;
  em: number;
  left: number;
  right: number;
  top: number;
  bottom: number;
  axis: number;
  disk: Disk | null;
  trace: TraceBox | null;
  x(place: number): number;
  y(level: number): number;
  place(x: number): number;
}

export type Colours = Record<string, string>;

/** What a layer is drawn with: a canvas' methods, of which `svg.js` has these. */
export type Drawn = Pick<
  CanvasRenderingContext2D,
  "beginPath" | "moveTo" | "lineTo" | "closePath" | "arc" | "stroke" | "fill"
> & { lineWidth: number; strokeStyle: any; fillStyle: any };

/** What a person has chosen. */
export interface Settings {
  felt: string;
  clicks: boolean;
  vibration: boolean;
  speech: boolean;
  volume: number;
  sweep: number;
  loop: boolean;
  name: string;
  contrast: boolean;
  still: boolean;
  start: number;
}
