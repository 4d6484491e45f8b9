// Types of kernel_node.js, for other pages that use the kernel.

export interface ControlEvent {
  /** Counted from the node's first sample; -1 (the default): at once. */
  sampleTime?: number;
  source?: string;
  /** Input angle in rad, 0 to pi. */
  theta2: number;
  touching: boolean;
}

export interface Strike {
  sample: number;
  /** Number of the event; -1 for the surface itself. */
  event: number;
  torque: number;
  level: number;
}

/** State of the kernel; peaks and new strikes cover the time since the last call. */
export interface KernelState {
  over: boolean;
  newStrikes: Strike[];
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
  /** Delay in s, up to 0.1. */
  delay?: number;
}

export class KernelNode extends AudioWorkletNode {
  onfault: (message: string) => void;
  control(theta2: number, touching: boolean, source?: string, sampleTime?: number): void;
  flush(): void;
  set(id: string, value: number | boolean, sampleTime?: number): void;
  change(bytes: ArrayBuffer): void;
  output(click: Signal, tactor: Signal): void;
  readState(): Promise<KernelState>;
  stop(): void;
}

export function openKernel(
  context: AudioContext | OfflineAudioContext,
  image: ArrayBuffer | Promise<ArrayBuffer>,
  options?: { events?: ControlEvent[]; changes?: ArrayBuffer[]; wasm?: Promise<ArrayBuffer> },
): Promise<KernelNode>;
