/** What page and worker say to each other. */
import type { Motion } from "./kernel";
import type { Assignment } from "./scene";

/** Steps between two rows of the history, as `fabric run` has it; outcomes are tested as often. */
export const ROW = 64;
/** Most steps of a run, as there. */
export const MOST_STEPS = 100_000;

/** Columns of a row: those of history.csv of `fabric run`. Forces are means since the row before. */
export const COLUMNS = [
  "step", "time_s", "position_x_m", "position_y_m", "position_z_m", "velocity_x_m_per_s", "velocity_y_m_per_s", "velocity_z_m_per_s",
  "angular_velocity_x_rad_per_s", "angular_velocity_y_rad_per_s", "angular_velocity_z_rad_per_s", "force_x_n", "force_y_n", "force_z_n",
  "absorbed_j", "contact_loss_j", "projectile_kinetic_j", "fabric_kinetic_j", "strain_j", "dissipated_j", "viscous_j", "friction_j",
  "ply_loss_j", "support_work_j", "casing_loss_j", "attachment_j", "energy_residual_j", "momentum_residual_n_s", "failed_segments", "contacts", "max_deflection_m", "max_stretch",
] as const;
export type Column = (typeof COLUMNS)[number];
export type Row = Record<Column, number>;

/** The sheet at one time. */
export interface Frame {
  /** The last row; the sheet may be up to a row of steps further while it moves. */
  row: number;
  motion: Motion;
  /** Three coordinates of each node, m. */
  positions: Float32Array;
  /** Largest strain of each node, and largest damage 1 - alpha, of the live segments that meet in it. */
  strain: Float32Array;
  damage: Float32Array;
  /** Whether each segment has failed: those along x, row by row, then those along y. */
  failed: Uint8Array;
  peakForce: number;
}

/** How fast it goes, by the processor's time in steps alone. */
export interface Speed {
  nanosecondsPerNodeStep: number;
  slowerThanReality: number;
}

/** The state when nothing moves. */
export interface Rest {
  digest: string;
  /** What ended the run; "" if it can go on. */
  ended: string;
}

export type ToWorker =
  /** The kernel's module, gzip, base64. */
  | { kind: "kernel"; packed: string }
  /** A new scene, shown at its start. */
  | { kind: "scene"; number: number; fabric: string; values: Assignment[] }
  /** Microseconds of the event in a second; 0: as fast as it computes. */
  | { kind: "pace"; pace: number }
  /** anew: from the start, as always after the end. */
  | { kind: "run"; anew: boolean }
  | { kind: "pause" }
  /** To a row that may be new, and stay there. */
  | { kind: "go"; row: number }
  /** The page has drawn the last frame. */
  | { kind: "drawn" }
  /** Computes one shot to its end, as soon as that is certain. */
  | { kind: "shot"; fabric: string; values: Assignment[] }
  | { kind: "check" }
  /** Does a capsule again. */
  | { kind: "replay"; file: Uint8Array };

export type FromWorker =
  /** The worker runs: it is the first message. */
  | { kind: "begun" }
  | { kind: "ready"; version: string }
  | { kind: "made"; number: number; nodes: [number, number]; dt: number }
  | { kind: "refused"; number: number; field: string; text: string }
  /** latched: outcomes so far. */
  | { kind: "shown"; number: number; rows: Row[]; frame: Frame; speed: Speed | undefined; rest: Rest | undefined; running: boolean; latched: string[] }
  /** number: of the scene; without one the kernel itself cannot run. */
  | { kind: "failed"; number: number | undefined; text: string }
  /** How a shot ended. */
  | { kind: "shot"; through: boolean; residual: number }
  | { kind: "checked"; digests: Record<string, string>; seconds: number }
  /** Where a replay is, or what it found. */
  | { kind: "replayed"; text: string; ended: boolean };
