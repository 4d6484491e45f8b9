// The timeline, drawn once for a window and a size; the disk and the finger, drawn every frame.

export class View {
  #canvas;
  #context;
  #picture = null;
  #data = null;

  constructor(canvas) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d");
    new ResizeObserver(() => this.#fit()).observe(canvas);
  }

  // What `/data/timeline` answers.
  show(data) {
    this.#data = data;
    this.#picture = null;
  }

  draw(cursor, finger) {
    const { width, height } = this.#canvas;
    if (!width || !height) return;
    this.#picture ??= this.#paint(width, height);
    const context = this.#context;
    context.clearRect(0, 0, width, height);
    context.drawImage(this.#picture, 0, 0);
    const { color } = getComputedStyle(this.#canvas);
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = 2 * devicePixelRatio;
    context.beginPath();
    context.moveTo(cursor * width, 0);
    context.lineTo(cursor * width, height);
    context.stroke();
    if (finger !== null) {
      context.beginPath();
      context.arc(finger * width, height / 2, 12 * devicePixelRatio, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  #fit() {
    this.#canvas.width = Math.round(this.#canvas.clientWidth * devicePixelRatio);
    this.#canvas.height = Math.round(this.#canvas.clientHeight * devicePixelRatio);
    this.#picture = null;
  }

  #paint(width, height) {
    const picture = Object.assign(document.createElement("canvas"), { width, height });
    const data = this.#data;
    if (data === null) return picture;
    const context = picture.getContext("2d");
    const { color, accentColor } = getComputedStyle(this.#canvas);
    const base = height * 0.9;
    const tall = height * 0.6;
    const { level } = data.curve;
    context.fillStyle = accentColor;
    context.beginPath();
    context.moveTo(0, base);
    level.forEach((value, i) => {
      context.lineTo((i / (level.length - 1)) * width, base - value * tall);
    });
    context.lineTo(width, base);
    context.fill();
    context.fillStyle = color;
    const span = data.window[1] - data.window[0];
    const size = 5 * devicePixelRatio;
    for (const event of data.events) {
      const x = ((event.time_s - data.window[0]) / span) * width;
      context.fillRect(x - 1, height * 0.15, 2, base - height * 0.15);
      context.fillRect(x - size, height * 0.15 - size, 2 * size, 2 * size);
    }
    return picture;
  }
}
