// Types that the page's scripts share. site_data.py documents the files of a timeline.

import type { KernelState } from "./kernel_node";
import type { Announcer } from "./site/announcer.js";
import type { CombinedInput } from "./site/combined_input.js";
import type { Data } from "./site/data.js";
import type { Picture } from "./site/picture.js";
import type { Playback } from "./site/playback.js";
import type { Speech } from "./site/speech.js";
import type { ViewState } from "./site/view_state.js";
import type { Motor } from "./site/vibration.js";

/** One event of a window; `position` is 0 to 1 within it. */
export interface TimelineEvent {
  position: number;
  time_s: number;
  kind: string;
  label: string;
  /** Value of a series at the event. */
  value?: number;
  /** Change and its unit, of a rise or fall. */
  change?: [number, string];
  /** Team, 1 or 2; of a goal the one that scored. */
  side?: number;
  /** Score after a goal, "1-0" of a window; `scores.js` sets that of the whole timeline, "1–0". */
  score?: string;
}

/** An event kind: name, mark, number of events, and vibration pattern (ms on, off, ...). */
export interface Kind {
  name: string;
  shape: string;
  colour: string;
  count: number;
  pattern: number[];
}

export interface TimeRange {
  start_s: number;
  end_s: number;
}

/** One of the listed windows. */
export interface Window extends TimeRange {
  level: number;
}

/** A visible part of the timeline: a listed window by its number, or any other (number -1). */
export interface Part extends TimeRange {
  number: number;
  zoom: number;
}

export interface Points {
  time_s: number[];
  value: number[];
}

/** Points of a window's map from time (s of the timeline) to position; linear in between. */
export interface AngleMap {
  time_s: number[];
  position: number[];
}

/** Contents of a visible part, for the picture and for speech. */
export interface View extends Part {
  /** null where position is proportional to time. */
  angle_map: AngleMap | null;
  /** null without data. */
  level: (number | null)[];
  /** Minimum and maximum of each column's levels; null if each column has one value. */
  band: [(number | null)[], (number | null)[]] | null;
  gaps: [number, number][];
  events: TimelineEvent[];
  strike_events: number[];
  scale: [number, number];
  points: Points | null;
  /** Distance (0 to 1) at which a position is at an event; `ViewState` sets it for the picture. */
  tolerance?: number;
  /** Position up to which a live timeline is known. */
  now?: number;
  /** Score at the window's start, if a goal was before it; `scores.js` sets it. */
  score?: string;
}

export interface Series {
  unit: string;
  decimals: number;
  complete: boolean;
  has_times: boolean;
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
  pages: string[];
}

/** Data that hold for all windows. */
export interface Info {
  title: string;
  /** Names of both teams, or none. */
  sides: string[];
  preset: string;
  duration_s: number;
  start: string | null;
  series: Series | null;
  reference_torque: number;
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

/** A notice of a live timeline (live_data.py). */
export interface Notice {
  version: number;
  status_text: string;
  changes: {
    action: string;
    kind: string;
    label: string;
    change?: [number, string];
    time_s: number;
    pattern: number[];
    version: number;
  }[];
  /** The update in base64, if it was requested. */
  update?: string;
}

/** Contents of a live timeline's new version, shown as the whole timeline. */
export interface NewVersion {
  info: Pick<Info, "title" | "sides" | "duration_s" | "kinds" | "notes" | "series">;
  view: Omit<View, keyof Part | "points">;
}

/** Changes of a live timeline since a version. */
export interface Update extends NewVersion {
  version: number;
  rate: number;
  bytes: number;
  packed?: boolean;
  patch: ArrayBuffer;
}

export type EventKind = Record<string, any> & { points: number[]; modes: Record<string, number>[] };

/** A preset as JSON (dicts.py). */
export interface Preset {
  name: string;
  values: Record<string, any>;
  kinds: Record<string, EventKind>;
  points: number[];
}

/** One row of the parameter table. */
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

/** A quantity that the user draws: texts, the curve without points, and whether all points may be 0. */
export interface Drawing {
  name: string;
  label: string;
  doc: string;
  back: string;
  plain: (part: number) => number;
  empty: boolean;
}

/** State of the disk; a host reports fewer fields. */
export type DiskState = Pick<KernelState, "cursor" | "touching" | "torque" | "envelope" | "newStrikes"> & Partial<KernelState>;

/** Sound output: this browser, or a host, for which some methods do nothing. */
export interface AudioBackend {
  clock: Clock;
  /** Whether it reports states of the disk. */
  readonly running: boolean;
  /** Whether there is no sound output: the disk then follows the input. */
  readonly isSilent: boolean;
  /** Whether a touch will be heard. */
  readonly ready: boolean;
  /** Sample rate of its changes, Hz; 0 for a host, which makes its own. */
  readonly rate: number;
  load(): Promise<void>;
  start(): void;
  /** Wait until the output runs, or none has started. */
  resume(): Promise<void>;
  control(position: number, touching: boolean, sample: number): void;
  route(output: string): void;
  volume(click: number, tactor: number): void;
  show(part: Part): Promise<() => void>;
  change(bytes: ArrayBuffer): void;
  changePreset(before: Preset, after: Preset, part: Part | null): Promise<void>;
  /** Return the disk's state; null before there is one. */
  readState(): Promise<DiskState | null>;
  onstate(sounds: boolean): void;
  onsilence(): void;
  setName(name: string): void;
}

/** Conversion from the page's clock (ms) to samples of control events. */
export interface Clock {
  rate: number;
  sampleAt(time: number): number;
  rendering(time: number): number;
}

/** Status of a host's disk (session.py). */
export interface Status {
  cursor: number;
  touching: boolean;
  torque_nm: number;
  envelope: number;
  window: [number, number];
  round_trip_ms: number | null;
  event_to_sample_ms: number | null;
  output_ms: number;
  others: OtherInput[];
}

export interface OtherInput {
  name: string;
  position: number;
  active: boolean;
}

export interface Sweep {
  name: "sweep";
  seconds: number;
  from: number;
  to: number;
}

export interface Tap {
  name: "tap";
  position: number;
}

export type Gesture = Sweep | Tap;

/** Source of control events on this page. */
export type Source = "touch" | "twist" | "keys" | "play";

export interface Disk {
  x: number;
  y: number;
  radius: number;
}

/** Layout of the picture, in CSS pixels. */
export interface Geometry {
  width: number;
  height: number;
  em: number;
  left: number;
  right: number;
  top: number;
  bottom: number;
  /** Radius of the disk. */
  radius: number;
  /** y of the lanes of marks: none of a series, one, or one for each team. */
  lanes: number[];
  /** y of the groove's middle. */
  groove: number;
  dial: Disk | null;
  still: boolean;
  x(position: number): number;
  y(level: number): number;
  position(x: number): number;
}

/** Mark of an event kind: shape, colours by name, and whether only the outline is drawn. */
export interface Mark {
  shape: string;
  colour: string;
  /** Colour of the rim, if it isn't the paper's. */
  rim?: string;
  isRing: boolean;
}

export type Colours = Record<string, string>;

/** Canvas methods used to draw; `svg.js` implements them too. */
export type PathContext = Pick<
  CanvasRenderingContext2D,
  "beginPath" | "moveTo" | "lineTo" | "closePath" | "arc" | "stroke" | "fill"
> & { lineWidth: number; strokeStyle: any; fillStyle: any };

/** Settings of the user, stored in this browser. */
export interface Settings {
  output: string;
  clicks: boolean;
  vibration: boolean;
  speech: boolean;
  volume: number;
  sweep: number;
  loop: boolean;
  steps: string;
  name: string;
  contrast: boolean;
  circular: boolean;
  still: boolean;
  start: number;
}

/** What parts of the page do with it: show an error ("" removes it), draw again, start and pause. */
export interface PageActions {
  fault(line: string): void;
  wake(): void;
  start(): void;
  pause(): void;
}

/** What is read out: position (0 to 1), time (s) and the event there. */
export interface ReadOut {
  position: number;
  moment: number;
  event: TimelineEvent | null;
}

interface SharedParts {
  actions: PageActions;
  announcer: Announcer;
  /** Whether a host plays. */
  atHost: boolean;
  data: Data;
  info: Info;
  input: CombinedInput;
  settings: Settings;
  viewState: ViewState;
}

/** What the features of a server use. */
export interface ServedParts extends SharedParts {
  picture: Picture;
  /** Position of the disk. */
  cursor(): number;
  changePreset(before: Preset, after: Preset, surface: boolean): Promise<void>;
  readOut(): ReadOut;
}

/** What a live timeline uses. */
export interface LiveParts extends SharedParts {
  motor: Motor;
  playback: Playback;
  sound: AudioBackend;
  speech: Speech;
  showAbout(): void;
}

type Plain = "title" | "window" | "link" | "latency" | "moment" | "when" | "clock" | "let-go" | "value" | "number" | "unit" | "event"
  | "strip" | "strip-window" | "stage" | "at-disk" | "at-input" | "passed" | "disk" | "arc" | "torque" | "needle" | "others" | "cursor" | "ring" | "dot"
  | "finger" | "pull" | "hint" | "hint-text" | "tools" | "legend" | "zooming" | "summary" | "announcement" | "fault" | "run-text"
  | "events-title" | "events-summary" | "kinds" | "found" | "events-list" | "values-title" | "values-note" | "values-head"
  | "values-rows" | "help-title" | "keys" | "dialog-title" | "more-title" | "motor" | "share-access" | "about" | "marks" | "editor"
  | "editor-title" | "editor-differences" | "editor-difference" | "editor-difference-list" | "editor-rows" | "editor-message" | "film-title";
type Button = "play" | "watch" | "twist" | "out" | "in" | "whole" | "settings" | "previous" | "run" | "next" | "list" | "all-values"
  | "values-more" | "calibrate" | "share" | "mark" | "learn" | "tune" | "editor-a" | "editor-b" | "editor-undo" | "editor-close"
  | "editor-save" | "editor-download";

/** Elements of index.html by their id. */
export interface Elements
  extends Record<Plain, HTMLElement>,
    Record<Button, HTMLButtonElement>,
    Record<"events" | "values" | "help" | "dialog" | "film", HTMLDialogElement>,
    Record<"slider" | "find" | "editor-find" | "share-play" | "share-token" | "editor-name", HTMLInputElement>,
    Record<"canvas" | "passed-curve" | "strip-curve", SVGSVGElement> {
  "values-download": HTMLAnchorElement;
  "settings-form": HTMLFormElement;
  "editor-preset": HTMLSelectElement;
  "film-video": HTMLVideoElement;
}
