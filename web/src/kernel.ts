/** The C interface (include/fabric_kernel.h) of the kernel for WebAssembly.
 *
 * All memory is the caller's: one simulation lives at a time, from the end of the module's own data on. */
import { constants, structures, wholes } from "built:data";
import { changesOf } from "./scene";
import type { Assignment } from "./scene";

interface Exports {
  memory: WebAssembly.Memory;
  __heap_base: WebAssembly.Global;
  print_digests(): number;
  fk_version(): number;
  fk_status_name(status: number): number;
  fk_scene_fill(scene: number, size: bigint, preset: number): number;
  fk_memory_size(scene: number, bytes: number): number;
  fk_init(block: number, bytes: bigint, scene: number, out: number, fault: number, size: bigint): number;
  fk_advance_until(sim: number, mask: number, steps: bigint, taken: number): number;
  fk_get_step_limits(sim: number, out: number, size: bigint): number;
  fk_get_grid(sim: number, out: number, size: bigint): number;
  fk_get_projectile(sim: number, out: number, size: bigint): number;
  fk_get_contact(sim: number, out: number, size: bigint): number;
  fk_get_energy(sim: number, out: number, size: bigint): number;
  fk_get_momentum_residual(sim: number, out: number): number;
  fk_get_fabric(sim: number, out: number, size: bigint): number;
  fk_get_counters(sim: number, out: number, size: bigint): number;
  fk_get_outcome(sim: number, out: number, size: bigint): number;
  fk_get_fault(sim: number, out: number, size: bigint): number;
  fk_copy_positions(sim: number, out: number, n: bigint): number;
  fk_copy_damage(sim: number, out: number, n: bigint): number;
  fk_copy_stretch(sim: number, out: number, n: bigint): number;
  fk_state_size(sim: number, bytes: number): number;
  fk_state_save(sim: number, image: number, bytes: bigint): number;
  fk_state_load(sim: number, image: number, bytes: bigint): number;
  fk_digest(sim: number, out: number): number;
  fk_capsule_read(capsule: number, bytes: bigint, scene: number, size: bigint, about: number, aboutSize: bigint): number;
  fk_replay(sim: number, capsule: number, bytes: bigint, steps: bigint, room: number, n: bigint, replay: number, size: bigint): number;
}

/** Constants of choices: a name of a scene file behind this. */
const CHOICES: Record<string, string> = { "attachment.kind": "FK_ATTACHMENT_", "projectile.shape": "FK_SHAPE_" };

function constant(name: string): number {
  const value = constants[name];
  if (value === undefined) throw new Error(`the header has no ${name}`);
  return value;
}

/** A request that the kernel refused, or a step that failed. */
export class Fault extends Error {
  constructor(readonly field: string, text: string) {
    super(text);
  }
}

export class Kernel {
  readonly exports: Exports;
  private written = "";
  private end = 0;

  constructor(module: WebAssembly.Module) {
    const write_text = (at: number): void => void (this.written += this.text(at));
    this.exports = new WebAssembly.Instance(module, { env: { write_text } }).exports as unknown as Exports;
    this.release();
  }

  version(): string {
    return this.text(this.exports.fk_version());
  }

  /** Runs the scenes of tests/digests/scenes.h: the digest of each by its name. */
  digests(): Record<string, string> {
    this.written = "";
    this.exports.print_digests();
    const lines = this.written.trim().split("\n").map((line) => line.split(" "));
    return Object.fromEntries(lines.map(([name = "", ...rest]) => [name, rest.join(" ")]));
  }

  /** Gives back all memory that was taken. */
  release(): void {
    this.end = this.exports.__heap_base.value as number;
  }

  take(bytes: number): number {
    const start = Math.ceil(this.end / 64) * 64;
    this.end = start + bytes;
    const more = this.end - this.exports.memory.buffer.byteLength;
    if (more > 0) this.exports.memory.grow(Math.ceil(more / 65536));
    return start;
  }

  view(): DataView {
    return new DataView(this.exports.memory.buffer);
  }

  bytes(at: number, count: number): Uint8Array {
    return new Uint8Array(this.exports.memory.buffer, at, count);
  }

  reals(at: number, count: number): Float64Array {
    return new Float64Array(this.exports.memory.buffer, at, count);
  }

  /** A text that ends with a zero. */
  text(at: number): string {
    const bytes = new Uint8Array(this.exports.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

/** A structure of the C header that the kernel fills. */
class Structure {
  readonly at: number;
  readonly size: number;
  private readonly fields: Record<string, [number, number]>;

  constructor(private readonly kernel: Kernel, name: string) {
    const layout = structures[name];
    if (!layout) throw new Error(`the header has no ${name}`);
    this.size = layout.size;
    this.fields = layout.fields;
    this.at = kernel.take(layout.size);
  }

  place(field: string): number {
    const found = this.fields[field];
    if (!found) throw new Error(`no field ${field}`);
    return this.at + found[0];
  }

  real(field: string, k = 0): number {
    return this.kernel.view().getFloat64(this.place(field) + 8 * k, true);
  }

  vector(field: string, count = 3): number[] {
    return Array.from({ length: count }, (_, k) => this.real(field, k));
  }

  whole(field: string): number {
    return Number(this.kernel.view().getBigUint64(this.place(field), true));
  }

  word(field: string): number {
    return this.kernel.view().getUint32(this.place(field), true);
  }

  text(field: string): string {
    return this.kernel.text(this.place(field));
  }

  set(field: string, value: number[], whole: boolean): void {
    const view = this.kernel.view();
    value.forEach((number, k) => {
      const at = this.place(field) + 8 * k;
      if (whole) view.setBigUint64(at, BigInt(number), true);
      else view.setFloat64(at, number, true);
    });
  }
}

/** Outcomes in the order of their numbers, and those that end a run, as in `fabric run`; through only where the scene watches it. */
export const OUTCOMES = ["arrested", "detached", "exited", "passed", "through", "rebounded", "attachment_failed"] as const;
const ENDS = ["FK_ENDS", "FK_THROUGH"];

export interface Motion {
  position: number[];
  velocity: number[];
  orientation: number[];
  angularVelocity: number[];
}

export class Simulation {
  readonly nodes: [number, number];
  readonly horizontal: number;
  readonly vertical: number;
  readonly dt: number;
  /** Bytes of a snapshot. */
  readonly imageSize: number;
  private readonly sim: number;
  private readonly one: number;
  private readonly image: number;
  private readonly numbers: number;
  private readonly fault: Structure;
  private readonly read: (name: string, call: (sim: number, out: number, size: bigint) => number) => Structure;
  private readonly mask: number;

  constructor(private readonly kernel: Kernel, fabric: string, values: Assignment[]) {
    const { exports } = kernel;
    kernel.release();
    const scene = new Structure(kernel, "fk_scene");
    this.fault = new Structure(kernel, "fk_fault");
    this.one = kernel.take(8);
    this.must(exports.fk_scene_fill(scene.at, BigInt(scene.size), constant("FK_PRESET_SHEET_3IN_SPHERE")));
    const changes = Object.entries(changesOf(fabric)).map(([key, value]): Assignment => ({ key, value }));
    for (const { key, value } of [...changes, ...values]) {
      const numbers = typeof value === "string" ? [constant((CHOICES[key] ?? "") + value.toUpperCase())] : value;
      scene.set(key, numbers, wholes.includes(key));
    }
    const size = exports.fk_memory_size(scene.at, this.one);
    const bytes = size === 0 ? this.whole() : 0;
    const block = kernel.take(bytes);
    const made = exports.fk_init(block, BigInt(bytes), scene.at, this.one, this.fault.at, BigInt(this.fault.size));
    if (made !== 0) throw new Fault(this.fault.text("field"), this.fault.text("text"));
    this.sim = kernel.view().getUint32(this.one, true);

    const known = new Map<string, Structure>();
    this.read = (name, call) => {
      const structure = known.get(name) ?? new Structure(kernel, name);
      known.set(name, structure);
      this.must(call(this.sim, structure.at, BigInt(structure.size)));
      return structure;
    };
    const grid = this.read("fk_grid", exports.fk_get_grid);
    this.nodes = [grid.whole("nodes_x"), grid.whole("nodes_y")];
    this.horizontal = grid.whole("horizontal");
    this.vertical = grid.whole("vertical");
    this.dt = this.read("fk_step_limits", exports.fk_get_step_limits).real("dt");
    this.must(exports.fk_state_size(this.sim, this.one));
    this.imageSize = this.whole();
    this.image = kernel.take(this.imageSize);
    this.numbers = kernel.take(8 * 3 * this.nodes[0] * this.nodes[1]);
    this.mask = ENDS.reduce((mask, name) => mask | constant(name), 0);
  }

  private whole(): number {
    return Number(this.kernel.view().getBigUint64(this.one, true));
  }

  /** The fault of a call. */
  private must(status: number): void {
    if (status === 0) return;
    const text = this.kernel.text(this.kernel.exports.fk_status_name(status));
    throw new Fault("", text);
  }

  /** Steps until an outcome that ends the run. */
  advance(steps: number): void {
    const { exports } = this.kernel;
    const status = exports.fk_advance_until(this.sim, this.mask, BigInt(steps), this.one);
    if (status === 0) return;
    exports.fk_get_fault(this.sim, this.fault.at, BigInt(this.fault.size));
    throw new Fault(this.fault.text("field"), this.fault.text("text"));
  }

  counters(): { steps: number; failed: number; contacts: number } {
    const counters = this.read("fk_counters", this.kernel.exports.fk_get_counters);
    return { steps: counters.whole("steps"), failed: counters.whole("failed_segments"), contacts: counters.whole("contacts") };
  }

  projectile(): Motion {
    const motion = this.read("fk_motion", this.kernel.exports.fk_get_projectile);
    return {
      position: motion.vector("position"),
      velocity: motion.vector("velocity"),
      orientation: motion.vector("orientation", 4),
      angularVelocity: motion.vector("angular_velocity"),
    };
  }

  contact(): { impulse: number[]; work: number; loss: number; peak: number } {
    const contact = this.read("fk_contact", this.kernel.exports.fk_get_contact);
    return { impulse: contact.vector("impulse"), work: contact.real("work"), loss: contact.real("loss"), peak: contact.real("force_peak") };
  }

  /** Several of the energies at once, J. */
  energies(fields: readonly string[]): number[] {
    const energy = this.read("fk_energy", this.kernel.exports.fk_get_energy);
    return fields.map((field) => energy.real(field));
  }

  /** Length of what the momentum balance does not close by, N s. */
  momentumResidual(): number {
    const at = this.numbers;
    this.must(this.kernel.exports.fk_get_momentum_residual(this.sim, at));
    return Math.hypot(...this.kernel.reals(at, 3));
  }

  extremes(): { deflection: number; stretch: number } {
    const fabric = this.read("fk_fabric", this.kernel.exports.fk_get_fabric);
    return { deflection: fabric.real("max_deflection"), stretch: fabric.real("max_stretch") };
  }

  /** Outcomes that have latched, and whether one of them ends the run. */
  outcome(): { latched: string[]; ended: string } {
    const mask = this.read("fk_outcome", this.kernel.exports.fk_get_outcome).word("mask");
    const names = (bits: number): string[] => OUTCOMES.filter((_, k) => (bits >> k) & 1);
    return { latched: names(mask), ended: names(mask & this.mask).join(" and ") };
  }

  digest(): string {
    this.must(this.kernel.exports.fk_digest(this.sim, this.one));
    return this.kernel.view().getBigUint64(this.one, true).toString(16).padStart(16, "0");
  }

  /** The arrays are valid until the next call. */
  positions(): Float64Array {
    return this.copied(this.kernel.exports.fk_copy_positions, 3 * this.nodes[0] * this.nodes[1]);
  }

  damage(): Float64Array {
    return this.copied(this.kernel.exports.fk_copy_damage, this.horizontal + this.vertical);
  }

  stretch(): Float64Array {
    return this.copied(this.kernel.exports.fk_copy_stretch, this.horizontal + this.vertical);
  }

  private copied(call: (sim: number, out: number, n: bigint) => number, count: number): Float64Array {
    this.must(call(this.sim, this.numbers, BigInt(count)));
    return this.kernel.reals(this.numbers, count);
  }

  save(): Uint8Array {
    this.must(this.kernel.exports.fk_state_save(this.sim, this.image, BigInt(this.imageSize)));
    return this.kernel.bytes(this.image, this.imageSize).slice();
  }

  load(image: Uint8Array): void {
    this.kernel.bytes(this.image, this.imageSize).set(image);
    this.must(this.kernel.exports.fk_state_load(this.sim, this.image, BigInt(this.imageSize)));
  }
}

/** A capsule that is done again: what a program did to a simulation, compared bit by bit. */
export class Replay {
  private readonly sim: number;
  private readonly digest: number;
  private readonly capsule: number;
  private readonly room: number;
  private readonly about: Structure;
  private readonly found: Structure;

  constructor(private readonly kernel: Kernel, private readonly file: Uint8Array) {
    const { exports } = kernel;
    kernel.release();
    this.capsule = kernel.take(file.length);
    kernel.bytes(this.capsule, file.length).set(file);
    const scene = new Structure(kernel, "fk_scene");
    const fault = new Structure(kernel, "fk_fault");
    this.about = new Structure(kernel, "fk_capsule");
    this.found = new Structure(kernel, "fk_replayed");
    kernel.bytes(this.found.at, this.found.size).fill(0);
    const read = exports.fk_capsule_read(this.capsule, BigInt(file.length), scene.at, BigInt(scene.size), this.about.at, BigInt(this.about.size));
    if (read !== 0) throw new Fault("", `${kernel.text(exports.fk_status_name(read))} (byte ${this.about.whole("broken_at")})`);
    this.digest = kernel.take(8);
    this.room = kernel.take(8 * this.about.whole("room"));
    const size = exports.fk_memory_size(scene.at, this.digest);
    const bytes = size === 0 ? Number(kernel.view().getBigUint64(this.digest, true)) : 0;
    const block = kernel.take(bytes);
    if (exports.fk_init(block, BigInt(bytes), scene.at, this.digest, fault.at, BigInt(fault.size)) !== 0) throw new Fault(fault.text("field"), fault.text("text"));
    this.sim = kernel.view().getUint32(this.digest, true);
  }

  /** So many steps more: where it is, or what was found. */
  advance(steps: number): { text: string; ended: boolean } {
    const { exports } = this.kernel;
    const { about, found } = this;
    const status = exports.fk_replay(this.sim, this.capsule, BigInt(this.file.length), BigInt(steps), this.room, BigInt(about.whole("room")), found.at, BigInt(found.size));
    if (status !== 0) throw new Fault("", this.kernel.text(exports.fk_status_name(status)));
    const [, , calls = 0n, taken = 0n, digests = 0n, equalCalls = 0n, equalStep = 0n] = Array.from({ length: 7 }, (_, k) => this.kernel.view().getBigUint64(found.place("at") + 8 * k, true));
    const hex = (number: bigint): string => number.toString(16).padStart(16, "0");
    const of = (field: string): string => hex(this.kernel.view().getBigUint64(found.place(field), true));
    switch (found.whole("end")) {
      case constant("FK_REPLAY_GOES_ON"):
        return { text: `call ${calls} of ${about.whole("calls")}, step ${taken} of ${about.whole("steps")}`, ended: false };
      case constant("FK_REPLAY_SAME"):
        exports.fk_digest(this.sim, this.digest);
        return { text: `Same bits: ${calls} calls, ${taken} steps, ${digests} digests, the last ${hex(this.kernel.view().getBigUint64(this.digest, true))}.`, ended: true };
      default:
        return { text: `Differs at call ${calls}: the capsule has ${of("written")}, here it is ${of("found")}; last equal behind call ${equalCalls}, at step ${equalStep}.`, ended: true };
    }
  }
}
