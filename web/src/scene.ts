/** What the page lets choose, and the scene that it means: for the kernel, as a scene file, and in an address.
 *
 * A scene must mean the same bits in every browser, but Math.sin and Math.cos may differ in their last digit. So what is computed
 * with them is rounded to nine decimals, and the scene file has the rounded numbers. */
import { fabrics, fragments, preset } from "built:data";

export type Attachment = "two_sides" | "four_sides" | "four_corners" | "free";
export type Shape = "sphere" | "cylinder" | "box" | "disc_sector" | "fsp";

/** What the form has, in its units: mm, g, m/s, degrees. */
export interface Choices {
  /** "" is the paper's yarn with its scatter; else a file of the folder fabrics. */
  fabric: string;
  nodes: number;
  /** Nodes along y; 0: as many as along x. */
  rows: number;
  /** Yarns that one bar of the network stands for. */
  bar: number;
  /** Radius of a sheet curved about its y axis, 0: flat; closed: a ring. */
  curve: number;
  closed: "no" | "yes";
  /** A case about the ring's axis, 0: none, and its window: angle and place along y of the middle, and half of both lengths. */
  casing: number;
  windowAngle: number;
  windowHalfAngle: number;
  windowY: number;
  windowHalfY: number;
  /** Bonded into one network. */
  plies: number;
  /** Thickness of a ply, mm, -1: that of the fabric. */
  thickness: number;
  attachment: Attachment;
  /** Force at which a yarn end slips, 0: never; in N or in parts of the yarn's strength. */
  hold: number;
  holdIn: "newton" | "yarn";
  /** Length of yarn in the clamp, mm, 0: without end. */
  grip: number;
  /** Force at which one attachment fails, N, 0: never. */
  strength: number;
  shape: Shape;
  radius: number;
  bore: number;
  length: number;
  /** Calibre of a fragment simulator, whose mass it determines. */
  calibre: string;
  /** Edges of a box, whose third edge is the length. */
  edgeX: number;
  edgeY: number;
  angle: number;
  mass: number;
  speed: number;
  /** Angle of the flight to the normal of the sheet, towards x. */
  oblique: number;
  /** Coefficient between yarn and fragment. */
  friction: number;
  tiltX: number;
  tiltY: number;
  turn: number;
  x: number;
  y: number;
  seed: number;
}

export const DEFAULTS: Choices = {
  fabric: "", nodes: 105, rows: 0, bar: 1, curve: 0, closed: "no", casing: 0, windowAngle: 0, windowHalfAngle: 0, windowY: 0, windowHalfY: 0, plies: 1, thickness: -1, attachment: "four_sides", hold: 0, holdIn: "newton", grip: 0, strength: 0, shape: "sphere", radius: 6.35, bore: 10, length: 12.7, calibre: ".22", edgeX: 12.7, edgeY: 12.7, angle: 60, mass: 8.4, speed: 100, oblique: 0, friction: 0,
  tiltX: 0, tiltY: 0, turn: 0, x: 0, y: 0, seed: 1,
};

/** Radius of the scene "ring", mm: where its chords close. */
const RING = 231.465553;

/** Scenes with a name; their digests are computed by the native library when the page is built. The page opens with the first. */
export const NAMED: { name: string; title: string; changes: Partial<Choices> }[] = [
  { name: "kevlar", title: "One ply of Kevlar KM2 S706, steel sphere, 150 m/s", changes: { fabric: "kevlar_km2_s706", nodes: 136, radius: 2.778, mass: 0.69, speed: 150 } },
  { name: "hole", title: "Sphere, 100 m/s: a hole", changes: {} },
  { name: "held", title: "Sphere, 40 m/s: arrested", changes: { speed: 40 } },
  { name: "corners", title: "Four corners held", changes: { attachment: "four_corners" } },
  { name: "cylinder", title: "Tilted cylinder, off the middle", changes: { shape: "cylinder", length: 20, mass: 14, speed: 110, tiltX: 35, tiltY: 10, x: 8, y: -5 } },
  { name: "sector", title: "Sector of a turbine disc, rim first", changes: { shape: "disc_sector", radius: 30, length: 8, mass: 28, speed: 80, tiltY: 20 } },
  { name: "chisel", title: "Fragment simulator of 17 grains, its chisel nose ahead, 150 m/s", changes: { fabric: "kevlar_km2_s706", nodes: 101, shape: "fsp", speed: 150 } },
  { name: "ring", title: "Ring of Zylon on a case with a window, a third of a disc from inside", changes: { fabric: "zylon_as_500_35", nodes: 501, rows: 88, bar: 4, plies: 5, curve: RING, closed: "yes", casing: RING, windowHalfAngle: 20, windowHalfY: 40, attachment: "free", shape: "disc_sector", bore: 15, radius: 40, length: 10, angle: 120, mass: 118, speed: 92 } },
  { name: "large", title: "10 in sheet, cylinder (350 x 350 nodes: slow)", changes: { nodes: 350, attachment: "two_sides", shape: "cylinder", length: 38.1, mass: 37, speed: 100 } },
];

/** The named scene that these choices are. */
export function nameOf(choices: Choices): string | undefined {
  const address = toAddress(choices);
  return NAMED.find((scene) => toAddress({ ...DEFAULTS, ...scene.changes }) === address)?.name;
}

/** The fields that a shape reads. */
export const DIMENSIONS: Record<Shape, (keyof Choices)[]> = {
  sphere: ["mass", "radius"],
  cylinder: ["mass", "radius", "length", "tiltX", "tiltY", "turn"],
  box: ["mass", "edgeX", "edgeY", "length", "tiltX", "tiltY", "turn"],
  disc_sector: ["mass", "radius", "bore", "length", "angle", "tiltX", "tiltY", "turn"],
  fsp: ["calibre", "tiltX", "tiltY", "turn"],
};

/** One parameter of the kernel: numbers in SI units, or the name of a choice. Keys are those of scene files. */
export type Assignment = { key: string; value: number[] | string };

type Vector = [number, number, number];
type Quaternion = [number, number, number, number];

const rounded = (x: number): number => Math.round(x * 1e9) / 1e9 + 0;

function product(a: Quaternion, b: Quaternion): Quaternion {
  const [p, q] = [a, b];
  return [
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
    p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
    p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
  ];
}

function about(axis: 0 | 1 | 2, degrees: number): Quaternion {
  const half = (degrees * Math.PI) / 360;
  const turn: Quaternion = [Math.cos(half), 0, 0, 0];
  turn[axis + 1] = Math.sin(half);
  return turn;
}

/** The host's z of a point of the body. */
function height(q: Quaternion, [x, y, z]: Vector): number {
  const [w, a, b, c] = q;
  return 2 * (a * c - w * b) * x + 2 * (b * c + w * a) * y + (1 - 2 * (a * a + b * b)) * z;
}

/** Corners of a disc sector's profile about its centre of mass, m: body x outward along its middle, counter-clockwise. */
export function profile(choices: Choices): [number, number][] {
  const half = (choices.angle * Math.PI) / 360;
  const at = (radius: number, turn: number): [number, number] => [1e-3 * radius * Math.cos(turn), 1e-3 * radius * Math.sin(turn)];
  const bore = choices.bore > 0 ? [at(choices.bore, half), at(choices.bore, -half)] : [at(0, 0)];
  const corners = [...bore, ...Array.from({ length: 9 }, (_, k) => at(choices.radius, half * (k / 4 - 1)))];
  let [area, moment] = [0, 0];
  corners.forEach(([x, y], k) => {
    const [nextX, nextY] = corners[(k + 1) % corners.length] ?? [0, 0];
    const cross = x * nextY - nextX * y;
    area += cross / 2;
    moment += ((x + nextX) * cross) / 6;
  });
  return corners.map(([x, y]) => [x - moment / area, y]);
}

/** What a fragment simulator changes in the preset. */
function simulator(choices: Choices): Record<string, number[]> {
  const found = fragments[choices.calibre];
  if (!found) throw new Error(`the page has no calibre ${choices.calibre}`);
  return found;
}

/** Mass of the fragment, g. */
export function mass(choices: Choices): number {
  return choices.shape === "fsp" ? 1e3 * (simulator(choices)["projectile.mass"]?.[0] ?? 0) : choices.mass;
}

/** Corners of a fragment simulator about its centre of mass, m: where three planes meet, within the others. */
export function vertices(choices: Choices): Vector[] {
  const flat = simulator(choices)["projectile.faces.planes"] ?? [];
  const planes = Array.from({ length: flat.length / 4 }, (_, k) => flat.slice(4 * k, 4 * k + 4) as [number, number, number, number]);
  const cross = (a: number[], b: number[]): Vector => [a[1]! * b[2]! - a[2]! * b[1]!, a[2]! * b[0]! - a[0]! * b[2]!, a[0]! * b[1]! - a[1]! * b[0]!];
  const dot = (a: number[], b: number[]): number => a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;
  const found: Vector[] = [];
  planes.forEach((a, i) => planes.slice(0, i).forEach((b, j) => planes.slice(0, j).forEach((c) => {
    const [bc, ca, ab] = [cross(b, c), cross(c, a), cross(a, b)];
    const volume = dot(a, bc);
    if (Math.abs(volume) < 1e-6) return;
    const corner = [0, 1, 2].map((k) => (bc[k]! * a[3] + ca[k]! * b[3] + ab[k]! * c[3]) / volume) as Vector;
    if (planes.every((plane) => dot(plane, corner) <= plane[3] + 1e-9)) found.push(corner);
  })));
  return found;
}

/** How the body is turned: a cylinder or a box stands on the sheet, a sector strikes it with its rim; then the tilts, then the turn. */
function orientation(choices: Choices): Quaternion {
  if (choices.shape === "sphere") return [1, 0, 0, 0];
  const start: Quaternion = choices.shape === "disc_sector" ? [0.5, -0.5, -0.5, -0.5] : [1, 0, 0, 0];
  const tilted = product(about(1, choices.tiltY), product(about(0, choices.tiltX), start));
  return product(about(2, choices.turn), tilted).map(rounded) as Quaternion;
}

/** How far the body reaches towards the sheet from its centre of mass, m. */
function reach(choices: Choices, q: Quaternion): number {
  const [radius, half] = [1e-3 * choices.radius, 5e-4 * choices.length];
  if (choices.shape === "sphere") return radius;
  if (choices.shape === "fsp") return Math.max(...vertices(choices).map((corner) => height(q, corner)));
  if (choices.shape === "box") {
    const [x, y] = [5e-4 * choices.edgeX, 5e-4 * choices.edgeY];
    return x * Math.abs(height(q, [1, 0, 0])) + y * Math.abs(height(q, [0, 1, 0])) + half * Math.abs(height(q, [0, 0, 1]));
  }
  if (choices.shape === "cylinder") {
    const axis = height(q, [0, 0, 1]);
    return half * Math.abs(axis) + radius * Math.sqrt(Math.max(0, 1 - axis * axis));
  }
  const corners = profile(choices).flatMap(([x, y]): Vector[] => [[x, y, half], [x, y, -half]]);
  return Math.max(...corners.map((corner) => height(q, corner)));
}

/** Radius of a ball about the fragment, m. */
export function ball(choices: Choices): number {
  if (choices.shape === "fsp") return Math.max(...vertices(choices).map((corner) => Math.hypot(...corner)));
  const [radius, length] = [1e-3 * choices.radius, 1e-3 * choices.length];
  const flat = choices.shape === "disc_sector" ? Math.max(...profile(choices).map((corner) => Math.hypot(...corner))) : choices.shape === "box" ? 5e-4 * Math.hypot(choices.edgeX, choices.edgeY) : radius;
  return choices.shape === "sphere" ? Math.abs(radius) : Math.hypot(flat, length / 2);
}

/** Whether the fragment cannot meet the sheet: whether the ball about it does not, on its way through the sheet's plane; inside a curved
 * sheet along y only. Not so where its dimensions make no body: those the kernel refuses. */
export function misses(choices: Choices): boolean {
  const [x, y, far, [right, top]] = [1e-3 * choices.x, 1e-3 * choices.y, ball(choices), extent(choices)[1]];
  const way = 2 * far * Math.tan((choices.oblique * Math.PI) / 180);
  const beside = x + Math.min(0, way) - far > right || x + Math.max(0, way) + far < -right;
  return (choices.curve === 0 && beside) || Math.abs(y) - far > top;
}

/** Nodes along y. */
export function rows(choices: Choices): number {
  return choices.rows || choices.nodes;
}

/** Radius at which the chords of a row close to a ring, mm. */
export function closing(choices: Choices): number {
  return 1e3 * rounded(spacing(choices) / (2 * Math.sin(Math.PI / choices.nodes)));
}

/** The box about the sheet at rest, m: its least and its greatest corner. */
export function extent(choices: Choices): [Vector, Vector] {
  const [radius, y] = [1e-3 * choices.curve, 0.5 * (rows(choices) - 1) * spacing(choices)];
  const flat = 0.5 * (choices.nodes - 1) * spacing(choices);
  if (radius === 0) return [[-flat, -y, 0], [flat, y, 0]];
  const half = Math.min(Math.PI, (choices.nodes - 1) * Math.asin(Math.min(1, (0.5 * spacing(choices)) / radius)));
  const x = radius * Math.sin(Math.min(half, Math.PI / 2));
  return [[-x, -y, radius * Math.cos(half)], [x, y, radius]];
}

/** What a fabric changes in the preset; nothing for "". */
export function changesOf(fabric: string): Record<string, number[]> {
  const changes = fabric === "" ? {} : fabrics[fabric];
  if (!changes) throw new Error(`the page has no fabric ${fabric}`);
  return changes;
}

/** A parameter of the fabric, or of the preset where the fabric does not change it. */
export function parameter(fabric: string, key: string): number {
  const [value] = changesOf(fabric)[key] ?? preset[key] ?? [];
  if (value === undefined) throw new Error(`the preset has no ${key}`);
  return value;
}

/** The distance of two nodes along x, m. */
export function spacing({ fabric, bar }: Choices): number {
  return parameter(fabric, "sheet.spacing") * bar;
}

/** Force at which a bar of one ply slips, N: as a scene file has it, to the bit. */
function hold({ fabric, bar, hold, holdIn }: Choices): number {
  if (holdIn === "newton") return hold * bar;
  const [modulus, stretch, area] = [parameter(fabric, "yarn.modulus_mean"), parameter(fabric, "yarn.critical_stretch"), parameter(fabric, "sheet.yarn_area") * bar];
  return ((hold * (modulus * area * (0.5 * (stretch * stretch - 1)) * stretch)) / bar) * bar;
}

/** What differs from the preset `sheet_3in_sphere`, beside what the fabric changes. */
export function assignments(choices: Choices): Assignment[] {
  const q = orientation(choices);
  const side = (Math.min(choices.nodes, rows(choices)) - 1) * spacing(choices);
  const all: Assignment[] = [
    { key: "seed", value: [choices.seed] },
    { key: "sheet.nodes_x", value: [choices.nodes] },
    { key: "sheet.nodes_y", value: [rows(choices)] },
    { key: "sheet.plies", value: [choices.plies] },
  ];
  // As `sheet.yarns_per_bar` of a scene file has it, to the bit.
  const changed = Object.keys(changesOf(choices.fabric)).filter((key) => /^sheet\.(spacing|yarn_area|node_mass)/.test(key));
  for (const key of choices.bar === 1 ? [] : new Set(["sheet.spacing", "sheet.node_mass", "sheet.yarn_area", ...changed])) {
    all.push({ key, value: [parameter(choices.fabric, key) * (key === "sheet.node_mass" ? choices.bar * choices.bar : choices.bar)] });
  }
  const circle = rounded(1e-3 * choices.curve);
  if (circle !== 0 || choices.closed === "yes") all.push({ key: "sheet.radius", value: [circle] }, { key: "sheet.closed", value: [choices.closed === "yes" ? 1 : 0] });
  // Curved cloth has no such viscosity.
  if (circle !== 0) all.push({ key: "yarn.viscosity_bending", value: [0] });
  const own = parameter(choices.fabric, "sheet.thickness");
  const half = 0.5 * ((choices.thickness < 0 ? own : rounded(1e-3 * choices.thickness)) * choices.plies);
  if (choices.thickness >= 0) all.push({ key: "sheet.thickness", value: [rounded(1e-3 * choices.thickness)] });
  if (choices.casing !== 0) {
    const window: [string, number[]][] = [
      ["radius", [choices.casing === choices.curve ? circle - half : 1e-3 * choices.casing]], ["window_angle", [choices.windowAngle, choices.windowHalfAngle].map((angle) => (angle * Math.PI) / 180)],
      ["window_place", [1e-3 * choices.windowY, 1e-3 * choices.windowHalfY]],
    ];
    all.push(...window.map(([key, value]) => ({ key: `casing.${key}`, value: value.map(rounded) })));
  }
  all.push({ key: "attachment.kind", value: choices.attachment });
  if (choices.attachment === "four_corners") {
    // As large beside the sheet as the paper's.
    all.push({ key: "attachment.disc_inset", value: [rounded(0.1 * side)] }, { key: "attachment.disc_radius", value: [rounded(0.075 * side)] });
  }
  const clamps = { hold: hold(choices), grip: rounded(1e-3 * choices.grip), strength: choices.strength };
  for (const [key, value] of Object.entries(clamps)) if (value !== 0) all.push({ key: `attachment.${key}`, value: [value] });
  if (choices.shape === "fsp") {
    all.push({ key: "projectile.shape", value: "polyhedron" }, ...Object.entries(simulator(choices)).map(([key, value]) => ({ key, value })));
  } else all.push({ key: "projectile.shape", value: choices.shape }, { key: "projectile.mass", value: [rounded(1e-3 * choices.mass)] });
  if (choices.shape === "disc_sector") {
    const sector: [string, number][] = [
      ["inner_radius", 1e-3 * choices.bore], ["outer_radius", 1e-3 * choices.radius], ["angle", (choices.angle * Math.PI) / 180], ["thickness", 1e-3 * choices.length],
    ];
    all.push(...sector.map(([key, value]) => ({ key: `projectile.sector.${key}`, value: [rounded(value)] })));
  } else if (choices.shape === "box") {
    all.push({ key: "projectile.size", value: [choices.edgeX, choices.edgeY, choices.length].map((edge) => rounded(1e-3 * edge)) });
  } else if (choices.shape !== "fsp") {
    all.push({ key: "projectile.radius", value: [rounded(1e-3 * choices.radius)] });
    if (choices.shape === "cylinder") all.push({ key: "projectile.length", value: [rounded(1e-3 * choices.length)] });
  }
  const gap = 2e-5;
  const flight = (choices.oblique * Math.PI) / 180;
  // Inside a curved sheet the ball about the fragment is as wide as the fragment may be.
  const inside = Math.sqrt(Math.max(0, circle * circle - (Math.abs(1e-3 * choices.x) + ball(choices)) ** 2));
  all.push(
    { key: "projectile.position", value: [1e-3 * choices.x, 1e-3 * choices.y, inside - reach(choices, q) - half - gap].map(rounded) },
    { key: "projectile.velocity", value: [choices.speed * Math.sin(flight), 0, choices.speed * Math.cos(flight)].map(rounded) },
    { key: "projectile.orientation", value: q },
    { key: "contact.friction", value: [choices.friction] },
  );
  return all;
}

/** The scene as a file for `fabric run`. */
export function toToml(choices: Choices): string {
  const lines = ["# Written by the page of fabric. `fabric run FILE` runs it and prints its digest.", 'preset = "sheet_3in_sphere"'];
  const written = ({ value }: Assignment, key: string): string => {
    if (typeof value === "string") return `${key} = "${value}"`;
    if (key === "closed") return `closed = ${value[0] === 1}`;
    return `${key} = ${value.length === 1 ? String(value[0]) : `[${value.join(", ")}]`}`;
  };
  // A scene file has yarns for the numbers of a bar that follow from them.
  const bars = (one: Assignment): Assignment[] => (one.key === "sheet.spacing" ? [{ key: "sheet.yarns_per_bar", value: [choices.bar] }] : /^sheet\.(spacing_y|node_mass|yarn_area)/.test(one.key) ? [] : [one]);
  const forces = (one: Assignment): Assignment[] => (one.key === "attachment.hold" ? [{ key: one.key, value: choices.holdIn === "yarn" ? `${choices.hold} of the yarn` : [choices.hold] }] : [one]);
  // And a calibre for faces, mass and moments.
  const fsp: Assignment[] = [{ key: "projectile.shape", value: "fsp" }, { key: "projectile.calibre", value: choices.calibre }];
  const calibres = (one: Assignment): Assignment[] => (choices.shape !== "fsp" || !/^projectile\.(shape|faces|mass|moments)/.test(one.key) ? [one] : one.key === "projectile.shape" ? fsp : []);
  const all = assignments(choices).flatMap(bars).flatMap(forces).flatMap(calibres);
  lines.push(...all.filter(({ key }) => !key.includes(".")).map((one) => written(one, one.key)));
  if (choices.fabric !== "") lines.push("", "[fabric]", `name = "${choices.fabric}"`);
  let group = "";
  for (const one of all.filter(({ key }) => key.includes("."))) {
    const [table = "", ...rest] = one.key.split(".");
    if (table !== group) lines.push("", `[${table}]`);
    group = table;
    lines.push(written(one, rest.join(".")));
  }
  return lines.join("\n") + "\n";
}

/** What differs from the defaults, as the part of an address behind "#". It is never empty: without it the page opens with its first scene. */
export function toAddress(choices: Choices): string {
  const differing = (Object.keys(DEFAULTS) as (keyof Choices)[]).filter((key) => choices[key] !== DEFAULTS[key]);
  return new URLSearchParams(differing.length > 0 ? differing.map((key) => [key, String(choices[key])]) : [["shape", choices.shape]]).toString();
}

/** Choices from an address, and what it has and the page does not understand, with the reason. */
export function fromAddress(address: string): { choices: Choices; unknown: string[] } {
  const choices: Choices = { ...DEFAULTS };
  const unknown: string[] = [];
  const allowed: Partial<Record<keyof Choices, readonly string[]>> = {
    fabric: ["", ...Object.keys(fabrics)],
    closed: ["no", "yes"],
    attachment: ["two_sides", "four_sides", "four_corners", "free"],
    holdIn: ["newton", "yarn"],
    shape: ["sphere", "cylinder", "box", "disc_sector", "fsp"],
    calibre: Object.keys(fragments),
  };
  for (const [key, text] of new URLSearchParams(address)) {
    const known = key in DEFAULTS ? (key as keyof Choices) : undefined;
    const names = known && allowed[known];
    const value = names ? text : Number(text);
    const good = names ? names.includes(text) : text.trim() !== "" && Number.isFinite(value);
    if (known && good) Object.assign(choices, { [known]: value });
    else unknown.push(`${key}=${text} (${!known ? "not known" : names ? "no such choice" : "not a number"})`);
  }
  return { choices, unknown };
}
