// Types of kernel_node.js, for pages that use the kernel by themselves.

export interface HandEvent {
  /** Counted from the node's first sample; -1 or left out: at once. */
  sampleTime?: number;
  source?: string;
  /** 0 to pi. */
  theta2: number;
  touching: boolean;
}

export interface Strike {
  sample: number;
  /** Number of the event, -1 for the bare surface. */
  event: number;
  torque: number;
  level: number;
}

/** What the kernel tells of itself; peaks are those since the last look. */
export interface Look {
  over: boolean;
  struck: Strike[];
  clock: number;
  cursor: number;
  touching: number;
  torque: number;
  friction: number;
  envelope: number;
  peakClick: number;
  peakTactor: number;
  strikes: number;
  [meter: string]: number | boolean | Strike[];
}

export interface Signal {
  gain?: number;
  ceiling?: number;
  /** s, to 0.1. */
  delay?: number;
}

export class KernelNode extends AudioWorkletNode {
  onfault: (message: string) => void;
  control(theta2: number, touching: boolean, source?: string, sampleTime?: number): void;
  flush(): void;
  set(id: string, value: number | boolean, sampleTime?: number): void;
  change(bytes: ArrayBuffer): void;
  output(click: Signal, tactor: Signal): void;
  look(): Promise<Look>;
  stop(): void;
}

export function openKernel(
  context: AudioContext | OfflineAudioContext,
  image: ArrayBuffer,
  given?: { events?: HandEvent[]; changes?: ArrayBuffer[]; wasm?: Promise<ArrayBuffer> },
): Promise<KernelNode>;
