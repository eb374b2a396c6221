/** Runs the kernel beside the page: steps in short pieces, so that it can be told to stop at any time, and keeps snapshots. */
import { Fault, Kernel, Replay, Simulation } from "./kernel";
import { MOST_STEPS, ROW } from "./messages";
import type { Frame, FromWorker, Rest, Row, ToWorker } from "./messages";

interface Page {
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
}
const page = self as unknown as Page;

/** Time in one piece of work, ms. */
const PIECE = 14;
/** Steps between two pictures at a pace, at least: a row is too long for slow motion. */
const FINE = 8;
/** Most memory and number of snapshots. */
const MOST_BYTES = 160e6;
const MOST_IMAGES = 64;

const ENERGIES = ["projectile_kinetic", "fabric_kinetic", "strain", "dissipated", "viscous", "friction", "ply_loss", "support_work", "casing_loss", "attachment", "residual"] as const;

/** Snapshots of a run, every so many rows; when there are too many, every second one is given up. */
class Images {
  private readonly kept = new Map<number, Uint8Array>();
  private every = 1;

  constructor(private readonly most: number) {}

  wants(row: number): boolean {
    return row % this.every === 0 && !this.kept.has(row);
  }

  keep(row: number, image: Uint8Array): void {
    this.kept.set(row, image);
    if (this.kept.size <= this.most) return;
    this.every *= 2;
    for (const old of [...this.kept.keys()]) if (old % this.every !== 0) this.kept.delete(old);
  }

  /** The last one up to a row. */
  before(row: number): [number, Uint8Array] | undefined {
    return [...this.kept].filter(([at]) => at <= row).sort(([a], [b]) => b - a)[0];
  }
}

/** A scene that runs. */
class Run {
  steps = 0;
  running = false;
  readonly sim: Simulation;
  private readonly images: Images;
  private lastImpulse = [0, 0, 0];
  private rows: Row[] = [];
  private known = -1;
  /** Time spent in steps, ms, and steps taken in it. */
  private spent = 0;
  private taken = 0;

  constructor(kernel: Kernel, readonly number: number, order: ToWorker & { kind: "scene" }) {
    this.sim = new Simulation(kernel, order.fabric, order.values);
    this.images = new Images(Math.max(8, Math.min(MOST_IMAGES, Math.floor(MOST_BYTES / this.sim.imageSize))));
    this.record();
  }

  /** Rows so far; the last may be shorter. */
  get row(): number {
    return this.steps === MOST_STEPS ? Math.ceil(this.steps / ROW) : Math.floor(this.steps / ROW);
  }

  get ended(): boolean {
    return this.sim.outcome().ended !== "" || this.steps >= MOST_STEPS;
  }

  /** So many steps, at most to the end of the row. */
  advance(most: number): void {
    const start = performance.now();
    const steps = Math.min(most, ROW - (this.steps % ROW), MOST_STEPS - this.steps);
    this.sim.advance(steps);
    this.spent += performance.now() - start;
    this.taken += steps;
    this.steps += steps;
    if (this.steps % ROW === 0 || this.steps === MOST_STEPS) this.record();
  }

  /** Stands still at a whole row only. */
  stop(): void {
    this.running = false;
    while (this.steps % ROW !== 0 && !this.ended) this.advance(ROW);
  }

  /** Goes to a row, from the last snapshot before it or from here. */
  go(row: number): void {
    const image = this.images.before(row);
    if (image && (row < this.row || image[0] > this.row)) {
      this.sim.load(image[1]);
      this.steps = this.sim.counters().steps;
      this.lastImpulse = this.sim.contact().impulse;
    }
    while (this.row < row && !this.ended) this.advance(ROW);
  }

  private record(): void {
    if (this.images.wants(this.row)) this.images.keep(this.row, this.sim.save());
    const { impulse, work, loss } = this.sim.contact();
    const { steps, failed, contacts } = this.sim.counters();
    const before = this.lastImpulse;
    this.lastImpulse = impulse;
    if (this.row <= this.known) return;
    this.known = this.row;
    const { position, velocity, angularVelocity } = this.sim.projectile();
    const [kinetic = 0, fabric = 0, strain = 0, dissipated = 0, viscous = 0, friction = 0, plies = 0, held = 0, onCasing = 0, clamps = 0, residual = 0] = this.sim.energies(ENERGIES);
    const { deflection, stretch } = this.sim.extremes();
    // As `fabric run` writes it, to the bit.
    const since = steps * this.sim.dt - (steps - ROW) * this.sim.dt;
    const force = (k: number): number => (this.row === 0 ? 0 : ((impulse[k] ?? 0) - (before[k] ?? 0)) / since);
    const of = (vector: number[], k: number): number => vector[k] ?? 0;
    this.rows.push({
      step: steps, time_s: steps * this.sim.dt,
      position_x_m: of(position, 0), position_y_m: of(position, 1), position_z_m: of(position, 2),
      velocity_x_m_per_s: of(velocity, 0), velocity_y_m_per_s: of(velocity, 1), velocity_z_m_per_s: of(velocity, 2),
      angular_velocity_x_rad_per_s: of(angularVelocity, 0), angular_velocity_y_rad_per_s: of(angularVelocity, 1), angular_velocity_z_rad_per_s: of(angularVelocity, 2),
      force_x_n: force(0), force_y_n: force(1), force_z_n: force(2),
      absorbed_j: work, contact_loss_j: loss, projectile_kinetic_j: kinetic, fabric_kinetic_j: fabric, strain_j: strain, dissipated_j: dissipated,
      viscous_j: viscous, friction_j: friction, ply_loss_j: plies, support_work_j: held, casing_loss_j: onCasing, attachment_j: clamps, energy_residual_j: residual,
      momentum_residual_n_s: this.sim.momentumResidual(), failed_segments: failed, contacts, max_deflection_m: deflection, max_stretch: stretch,
    });
  }

  /** Tells the page the new rows and the sheet as it is now. */
  show(): void {
    const frame = this.frame();
    const nodes = this.sim.nodes[0] * this.sim.nodes[1];
    const seconds = 1e-3 * this.spent;
    const speed = this.taken === 0 ? undefined : { nanosecondsPerNodeStep: (1e9 * seconds) / (this.taken * nodes), slowerThanReality: seconds / (this.taken * this.sim.dt) };
    const rest: Rest | undefined = this.running ? undefined : this.rest();
    const rows = this.rows;
    this.rows = [];
    const message: FromWorker = { kind: "shown", number: this.number, rows, frame, speed, rest, running: this.running, latched: this.sim.outcome().latched };
    page.postMessage(message, [frame.positions.buffer, frame.strain.buffer, frame.damage.buffer, frame.failed.buffer]);
  }

  private rest(): Rest {
    const { ended } = this.sim.outcome();
    return { digest: this.sim.digest(), ended: ended === "" && this.ended ? "the step limit" : ended };
  }

  private frame(): Frame {
    const [nx, ny] = this.sim.nodes;
    const positions = Float32Array.from(this.sim.positions());
    const alpha = Float32Array.from(this.sim.damage());
    const stretch = this.sim.stretch();
    const strain = new Float32Array(nx * ny);
    const damage = new Float32Array(nx * ny);
    const failed = new Uint8Array(alpha.length);
    const join = (segment: number, a: number, b: number): void => {
      const left = alpha[segment] ?? 1;
      if (left === 0) {
        failed[segment] = 1;
        return;
      }
      const [e, d] = [(stretch[segment] ?? 1) - 1, 1 - left];
      for (const node of [a, b]) {
        if (e > (strain[node] ?? 0)) strain[node] = e;
        if (d > (damage[node] ?? 0)) damage[node] = d;
      }
    };
    // The last segment of a ring's row ends at its first node.
    const across = this.sim.horizontal / ny;
    for (let j = 0, segment = 0; j < ny; j++) for (let i = 0; i < across; i++, segment++) join(segment, j * nx + i, j * nx + ((i + 1) % nx));
    for (let j = 0, segment = this.sim.horizontal; j + 1 < ny; j++) for (let i = 0; i < nx; i++, segment++) join(segment, j * nx + i, j * nx + i + nx);
    return { row: this.row, motion: this.sim.projectile(), positions, strain, damage, failed, peakForce: this.sim.contact().peak };
  }
}

let kernel: Kernel | undefined;
let run: Run | undefined;
let pace = 0;
/** When a paced run began, ms, and at which step. */
let paced: [number, number] = [0, 0];
let drawn = true;
let queued = false;

/** The next piece of work, after what the page may have said: a message to itself, as timers have a least delay. */
const next = new MessageChannel();
next.port1.onmessage = (): void => {
  queued = false;
  guarded(work);
};
function queue(): void {
  if (!queued) next.port2.postMessage(0);
  queued = true;
}

function work(): void {
  if (!run?.running) return;
  const start = performance.now();
  const due = pace === 0 ? Infinity : paced[1] + ((start - paced[0]) * 1e-9 * pace) / run.sim.dt;
  while (run.steps < due && performance.now() - start < PIECE && !run.ended) run.advance(pace === 0 ? ROW : FINE);
  if (run.ended) run.running = false;
  if (drawn || !run.running) {
    drawn = false;
    run.show();
  }
  if (!run.running) return;
  if (run.steps < due) queue();
  else setTimeout(queue, 5);
}

function start(anew: boolean): void {
  if (!run) return;
  if (anew || run.ended) run.go(0);
  run.running = true;
  paced = [performance.now(), run.steps];
  queue();
}

/** A failed step ends the run; the page says why. */
function guarded(action: () => void): void {
  try {
    action();
  } catch (error) {
    if (run) run.running = false;
    page.postMessage({ kind: "failed", number: run?.number ?? 0, text: error instanceof Error ? error.message : String(error) });
  }
}

function make(order: ToWorker & { kind: "scene" }): void {
  if (!kernel) return;
  run = undefined;
  try {
    run = new Run(kernel, order.number, order);
  } catch (error) {
    const [field, text] = error instanceof Fault ? [error.field, error.message] : ["", error instanceof RangeError ? "there is not enough memory for this sheet" : String(error)];
    page.postMessage({ kind: "refused", number: order.number, field, text });
    return;
  }
  page.postMessage({ kind: "made", number: order.number, nodes: run.sim.nodes, dt: run.sim.dt });
  run.show();
}

function shoot({ fabric, values }: ToWorker & { kind: "shot" }): void {
  if (!kernel) return;
  const sim = new Simulation(kernel, fabric, [...values, { key: "track_through", value: [1] }]);
  sim.advance(MOST_STEPS);
  const { ended } = sim.outcome();
  page.postMessage({ kind: "shot", through: ended !== "" && !ended.includes("arrested"), residual: Math.hypot(...sim.projectile().velocity) });
}

/** Unpacks and compiles the kernel. */
async function load(text: string): Promise<void> {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  module = await WebAssembly.compile(await new Response(stream).arrayBuffer());
  kernel = new Kernel(module);
  page.postMessage({ kind: "ready", version: kernel.version() });
}

function check(module: WebAssembly.Module): void {
  // A kernel of its own: the scenes have memory of their own, but the run must not see them.
  const begin = performance.now();
  const digests = new Kernel(module).digests();
  page.postMessage({ kind: "checked", digests, seconds: 1e-3 * (performance.now() - begin) });
}

/** In pieces, so that the page sees how far it is. */
async function replay(module: WebAssembly.Module, file: Uint8Array): Promise<void> {
  const capsule = new Replay(new Kernel(module), file);
  for (;;) {
    const found = capsule.advance(10 * ROW);
    page.postMessage({ kind: "replayed", ...found });
    if (found.ended) return;
    await new Promise((resolve) => setTimeout(resolve, 0));
  }
}

let module: WebAssembly.Module | undefined;
/** What was said before is done: loading takes time. */
let done: Promise<void> = Promise.resolve();
page.onmessage = ({ data }): void => {
  done = done.then(() => (data.kind === "kernel" ? load(data.packed) : guarded(() => answer(data)))).catch((error: unknown) => {
    page.postMessage({ kind: "failed", number: undefined, text: `this browser cannot run the kernel: ${String(error)}` });
  });
};

function answer(data: ToWorker): void {
  switch (data.kind) {
    case "scene":
      return make(data);
    case "pace":
      pace = data.pace;
      paced = [performance.now(), run?.steps ?? 0];
      return;
    case "run":
      return start(data.anew);
    case "pause":
    case "go":
      if (!run) return;
      run.stop();
      if (data.kind === "go") run.go(data.row);
      return run.show();
    case "drawn":
      drawn = true;
      return;
    case "shot":
      return shoot(data);
    case "check":
      return module && check(module);
    case "replay":
      if (module) {
        const refused = (error: unknown): void => page.postMessage({ kind: "replayed", text: `Refused: ${error instanceof Error ? error.message : String(error)}`, ended: true });
        replay(module, data.file).catch(refused);
      }
      return;
  }
}

page.postMessage({ kind: "begun" });
