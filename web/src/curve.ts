/** The limit's curve: shots at several velocities, in workers of their own with the same kernel. */
import { DEFAULTS, assignments, toAddress } from "./scene";
import type { Choices } from "./scene";
import type { FromWorker, ToWorker } from "./messages";

/** One shot; residual: velocity behind the sheet, 0 if it was not through. m/s. */
export interface Shot {
  speed: number;
  through: boolean;
  residual: number;
}

/** Most shots, and least and most velocity, m/s. */
const MOST_SHOTS = 24;
const RANGE = [2, 2000] as const;
/** The bracket in parts of the limit, and where above it the curve has points. */
const BRACKET = 0.02;
const ABOVE = [1.05, 1.1, 1.2, 1.35, 1.6, 2];

/** The largest velocity that was not through below the smallest that was; 0 and infinity where there is none. */
export function bracket(shots: readonly Shot[]): [number, number] {
  const high = Math.min(...shots.filter(({ through }) => through).map(({ speed }) => speed));
  const low = Math.max(0, ...shots.filter(({ through, speed }) => !through && speed < high).map(({ speed }) => speed));
  return [low, high];
}

/** The next velocity: out from the first until the limit lies between two shots, then halves, then points above it. pending: velocities
 * that are being computed. undefined: there is nothing more to do. */
export function nextSpeed(first: number, shots: readonly Shot[], pending: readonly number[]): number | undefined {
  const all = [...shots.map(({ speed }) => speed), ...pending].sort((a, b) => a - b);
  const [low, high] = bracket(shots);
  const [least = first, most = first] = [all[0], all[all.length - 1]];
  const next = ((): number | undefined => {
    if (all.length === 0) return first;
    if (high === Infinity) return 1.5 * most;
    if (low === 0) return least / 1.5;
    const inside = all.filter((speed) => speed >= low && speed <= high);
    const gaps = inside.slice(1).map((speed, k): [number, number] => [speed - (inside[k] ?? 0), ((inside[k] ?? 0) + speed) / 2]);
    const [widest = 0, middle] = gaps.sort(([a], [b]) => b - a)[0] ?? [];
    if (widest > BRACKET * high) return middle;
    return ABOVE.map((part) => part * high).find((speed) => all.every((other) => Math.abs(other - speed) > BRACKET * speed));
  })();
  const fits = next !== undefined && all.length < MOST_SHOTS && next >= RANGE[0] && next <= RANGE[1];
  return fits ? Math.round(10 * next) / 10 : undefined;
}

/** Shots at one scene. */
export class Curve {
  shots: Shot[] = [];
  /** Why the search ended, if not because the curve is complete. */
  problem = "";
  private scene = "";
  private crew: Worker[] = [];
  private readonly pending = new Map<Worker, number>();

  /** worker: starts one; changed: there is a new shot, or an end. */
  constructor(private readonly worker: () => Worker, private readonly kernel: ToWorker, private readonly changed: () => void) {}

  get busy(): boolean {
    return this.crew.length > 0;
  }

  /** Takes up a scene: true if it is another one, its velocity aside. */
  take(choices: Choices): boolean {
    const scene = toAddress({ ...choices, speed: DEFAULTS.speed });
    if (scene === this.scene) return false;
    this.stop();
    [this.scene, this.shots, this.problem] = [scene, [], ""];
    return true;
  }

  add(shot: Shot): void {
    this.shots = [...this.shots.filter(({ speed }) => speed !== shot.speed), shot].sort((a, b) => a.speed - b.speed);
    this.changed();
  }

  /** Starts workers, at most four and one processor less than there are. */
  begin(choices: Choices): void {
    this.problem = "";
    const count = Math.max(1, Math.min(4, navigator.hardwareConcurrency - 1));
    const send = (worker: Worker): void => {
      const speed = nextSpeed(choices.speed, this.shots, [...this.pending.values()]);
      if (speed === undefined) {
        if (this.pending.size === 0) this.stop();
        return;
      }
      this.pending.set(worker, speed);
      worker.postMessage({ kind: "shot", fabric: choices.fabric, values: assignments({ ...choices, speed }) } satisfies ToWorker);
    };
    this.crew = Array.from({ length: count }, this.worker);
    for (const worker of this.crew) {
      worker.onmessage = ({ data }: MessageEvent<FromWorker>): void => {
        const speed = this.pending.get(worker);
        if (data.kind === "ready") send(worker);
        else if (data.kind === "failed" && this.busy) {
          this.problem = `No shot${speed === undefined ? "" : ` at ${speed} m/s`}: ${data.text}.`;
          this.stop();
        } else if (data.kind === "shot" && speed !== undefined) {
          this.pending.delete(worker);
          this.add({ speed, through: data.through, residual: data.through ? data.residual : 0 });
          for (const idle of this.crew) if (!this.pending.has(idle)) send(idle);
        }
      };
      worker.postMessage(this.kernel);
    }
    this.changed();
  }

  stop(): void {
    for (const worker of this.crew) worker.terminate();
    this.crew = [];
    this.pending.clear();
    this.changed();
  }
}
