// Elements of the studies' page, for `byId`.

declare module "../overview_dsp/web/types" {
  interface Elements extends Record<"count" | "progress-line" | "said" | "study" | "waiting", HTMLElement> {
    progress: HTMLProgressElement;
  }
}

export {};
