// The finger, pen or mouse on an element: a drag holds the disk, a tap is a step, letting go lets it
// recoil. One pointer at a time: the first that is down.

export class Hand {
  #element;
  #pointer = null;
  #place = 0;

  // `push(timeMs, theta2, touching)` gets every event, coalesced ones too.
  constructor(element, push) {
    this.#element = element;
    element.addEventListener("pointerdown", (event) => {
      if (this.#pointer !== null || event.button !== 0) return;
      this.#pointer = event.pointerId;
      element.setPointerCapture(event.pointerId);
      push(event.timeStamp, this.#angle(event), true);
    });
    element.addEventListener("pointermove", (event) => {
      if (event.pointerId !== this.#pointer) return;
      const all = event.getCoalescedEvents?.() ?? [];
      for (const one of all.length ? all : [event]) push(one.timeStamp, this.#angle(one), true);
    });
    const up = (event) => {
      if (event.pointerId !== this.#pointer) return;
      this.#pointer = null;
      push(event.timeStamp, this.#place * Math.PI, false);
    };
    // `lostpointercapture` comes after each of the others, and where neither comes
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(type, up);
    }
    element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get place() {
    return this.#place;
  }

  get touching() {
    return this.#pointer !== null;
  }

  #angle(event) {
    const box = this.#element.getBoundingClientRect();
    this.#place = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
    return this.#place * Math.PI;
  }
}
