/** Small plots: the history over time, and the limit's curve. */
export interface Series<T> {
  name: string;
  /** Style sheet's variable with its colour. */
  colour: string;
  of: (row: T) => number;
}

/** What stands along the plot, and what a click into it does. */
export interface Axis<T> {
  unit: string;
  of: (row: T) => number;
  chosen: (value: number) => void;
  /** Whether each row is a point. */
  dots?: boolean;
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

export class Plot<T> {
  readonly figure = document.createElement("figure");
  private readonly canvas: HTMLCanvasElement;

  constructor(parent: HTMLElement, private readonly title: string, private readonly unit: string, private readonly series: Series<T>[], private readonly axis: Axis<T>) {
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
    this.canvas.setAttribute("aria-label", title);
    this.figure.append(caption, this.canvas);
    parent.append(this.figure);
    const pointed = (event: PointerEvent): void => {
      if (event.buttons === 0) return;
      const part = (event.offsetX - this.left) / (this.canvas.clientWidth - this.left - 6);
      axis.chosen(Math.min(1, Math.max(0, part)) * this.last);
    };
    this.canvas.addEventListener("pointerdown", pointed);
    this.canvas.addEventListener("pointermove", pointed);
  }

  private left = 44;
  private last = 0;

  /** at: the place along the axis that the picture shows; most: where the axis ends. */
  draw(rows: readonly T[], at: number, most = 0): void {
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

    const { of: along, unit } = this.axis;
    this.last = Math.max(most, 1, ...rows.slice(-1).map(along));
    let [low, high] = [0, 0];
    for (const { of } of this.series) for (const row of rows) [low, high] = [Math.min(low, of(row)), Math.max(high, of(row))];
    if (high - low < 1e-12) high = low + 1;
    const bottom = height - 18;
    const x = (value: number): number => this.left + (value / this.last) * (width - this.left - 6);
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
    for (const [value, label] of marks(0, this.last)) context.fillText(`${label} ${unit}`, Math.min(width - 22, Math.max(this.left, x(value))), height - 7);

    context.lineWidth = 1.6;
    context.lineJoin = "round";
    for (const { colour: name, of } of this.series) {
      context.strokeStyle = colour(name);
      context.beginPath();
      for (const row of rows) context.lineTo(x(along(row)), y(of(row)));
      context.stroke();
      context.fillStyle = colour(name);
      for (const row of this.axis.dots ? rows : []) context.fillRect(x(along(row)) - 3, y(of(row)) - 3, 6, 6);
    }
    if (rows.length > 0) {
      context.strokeStyle = colour("--text");
      context.lineWidth = 1;
      context.setLineDash([3, 3]);
      context.beginPath();
      context.moveTo(x(at), 4);
      context.lineTo(x(at), bottom);
      context.stroke();
    }
    const now = rows.find((row) => along(row) === at);
    if (now) {
      const values = this.series.map(({ name, of }) => `${this.series.length > 1 ? `${name} ` : ""}${of(now).toPrecision(4)}`);
      canvas.setAttribute("aria-label", `${this.title} at ${at.toFixed(1)} ${unit}: ${values.join(", ")} ${this.unit}`);
    }
  }
}
