/** Small plots of the history over time. */
import type { Row } from "./messages";

export interface Series {
  name: string;
  /** Style sheet's variable with its colour. */
  colour: string;
  of: (row: Row) => number;
}

/** 1, 2 or 5 times a power of ten, so that at most five steps cover a range. */
function stepOf(range: number): number {
  const power = 10 ** Math.floor(Math.log10(range / 5));
  const part = range / 5 / power;
  return power * (part > 5 ? 10 : part > 2 ? 5 : part > 1 ? 2 : 1);
}

/** The values at which a plot from low to high has lines, with their labels. A multiple of the step: a sum of steps misses zero. */
export function marks(low: number, high: number): [number, string][] {
  const step = stepOf(high - low);
  const found: [number, string][] = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k += 1) found.push([k * step, String(Number((k * step).toPrecision(6)) + 0)]);
  return found;
}

export class Plot {
  private readonly canvas: HTMLCanvasElement;

  /** chosen: called with a time, s, when the reader points into the plot. */
  constructor(parent: HTMLElement, private readonly title: string, private readonly unit: string, private readonly series: Series[], chosen: (time: number) => void) {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.append(`${title}, ${unit}`);
    if (series.length > 1) {
      for (const { name, colour } of series) {
        const key = document.createElement("span");
        key.className = "key";
        key.style.setProperty("--colour", `var(${colour})`);
        key.textContent = name;
        caption.append(key);
      }
    }
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    figure.append(caption, this.canvas);
    parent.append(figure);
    const pointed = (event: PointerEvent): void => {
      if (event.buttons === 0) return;
      const part = (event.offsetX - this.left) / (this.canvas.clientWidth - this.left - 6);
      chosen(Math.min(1, Math.max(0, part)) * this.last);
    };
    this.canvas.addEventListener("pointerdown", pointed);
    this.canvas.addEventListener("pointermove", pointed);
  }

  private left = 44;
  private last = 0;

  /** rows: the history; at: the row that the picture shows. */
  draw(rows: readonly Row[], at: number): void {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    // Drawn by the processor: for so few lines the graphics processor takes longer to set up.
    const context = canvas.getContext("2d", { willReadFrequently: true });
    if (!context || width === 0) return;
    const ratio = Math.min(2, window.devicePixelRatio);
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    const style = getComputedStyle(canvas);
    const colour = (name: string): string => style.getPropertyValue(name).trim();

    this.last = Math.max(rows[rows.length - 1]?.time_s ?? 0, 1e-6);
    let [low, high] = [0, 0];
    for (const { of } of this.series) for (const row of rows) [low, high] = [Math.min(low, of(row)), Math.max(high, of(row))];
    if (high - low < 1e-12) high = low + 1;
    const bottom = height - 18;
    const x = (time: number): number => this.left + (time / this.last) * (width - this.left - 6);
    const y = (value: number): number => bottom - ((value - low) / (high - low)) * (bottom - 6);

    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    context.fillStyle = colour("--quiet");
    context.strokeStyle = colour("--line");
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const [value, label] of marks(low, high)) {
      context.beginPath();
      context.moveTo(this.left, y(value));
      context.lineTo(width - 6, y(value));
      context.stroke();
      context.fillText(label, this.left - 5, y(value));
    }
    context.textAlign = "center";
    const stepTime = stepOf(1e6 * this.last);
    for (let time = 0; time <= 1e6 * this.last; time += stepTime) context.fillText(`${Number(time.toPrecision(4))} µs`, Math.min(width - 18, Math.max(this.left, x(1e-6 * time))), height - 7);

    context.lineWidth = 1.6;
    context.lineJoin = "round";
    for (const { colour: name, of } of this.series) {
      context.strokeStyle = colour(name);
      context.beginPath();
      for (const row of rows) context.lineTo(x(row.time_s), y(of(row)));
      context.stroke();
    }
    const now = rows[at];
    if (now) {
      context.strokeStyle = colour("--text");
      context.lineWidth = 1;
      context.setLineDash([3, 3]);
      context.beginPath();
      context.moveTo(x(now.time_s), 4);
      context.lineTo(x(now.time_s), bottom);
      context.stroke();
      const values = this.series.map(({ name, of }) => `${this.series.length > 1 ? `${name} ` : ""}${of(now).toPrecision(4)}`);
      canvas.setAttribute("aria-label", `${this.title} at ${(1e6 * now.time_s).toFixed(1)} µs: ${values.join(", ")} ${this.unit}`);
    }
  }
}
