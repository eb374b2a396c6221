/** The page: form, picture, plots and results. The worker computes. */
import { native, pinned } from "built:data";
import kernelText from "built:kernel";
import workerText from "built:worker";
import { Curve, bracket } from "./curve";
import type { Shot } from "./curve";
import { COLUMNS, ROW } from "./messages";
import type { Frame, FromWorker, Rest, Row, Speed, ToWorker } from "./messages";
import { Plot } from "./plots";
import type { Axis } from "./plots";
import { DEFAULTS, DIMENSIONS, NAMED, assignments, ball, closing, extent, fromAddress, mass, misses, nameOf, parameter, rows, toAddress, toToml } from "./scene";
import type { Choices, Shape } from "./scene";
import { View } from "./view";
import type { Colouring, Side } from "./view";

function element<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

const form = element("choices", HTMLFormElement);
const named = element("named", HTMLSelectElement);
const colouring = element("colouring", HTMLSelectElement);
const side = element("side", HTMLSelectElement);
const pace = element("pace", HTMLSelectElement);
const picture = element("picture", HTMLCanvasElement);
const runButton = element("run", HTMLButtonElement);
const time = element("time", HTMLInputElement);
const swift = element("swift", HTMLInputElement);
const search = element("search", HTMLButtonElement);
const outcome = element("outcome", HTMLElement);
const card = element("card", HTMLElement);
const problem = element("problem", HTMLElement);

/** Least and most of what the page itself limits: 501 x 501 nodes take some 60 MB. */
const LIMITS: Partial<Record<keyof Choices, [number, number]>> = { nodes: [11, 501], rows: [0, 501], bar: [1, 100], curve: [0, 1e6], casing: [0, 1e6], plies: [1, 1000], seed: [0, Number.MAX_SAFE_INTEGER], bore: [0, 1e3], oblique: [-80, 80], speed: [0.1, 1e6], mass: [1e-3, 1e6] };
const WHOLE: (keyof Choices)[] = ["nodes", "rows", "bar", "plies", "seed"];
/** Field of the form that a parameter of the kernel comes from. */
const FIELDS: [string, keyof Choices][] = [
  ["projectile.sector.inner_radius", "bore"], ["projectile.sector.outer_radius", "radius"], ["projectile.sector.angle", "angle"],
  ["projectile.sector.thickness", "length"], ["projectile.radius", "radius"], ["projectile.length", "length"], ["projectile.mass", "mass"],
  ["projectile.velocity", "speed"], ["contact.friction", "friction"], ["projectile.position", "x"], ["projectile.orientation", "tiltX"],
  ["projectile.size", "edgeX"],
  ["attachment.hold", "hold"], ["attachment.grip", "grip"], ["attachment.strength", "strength"], ["attachment", "attachment"], ["sheet.plies", "plies"], ["sheet.thickness", "thickness"], ["sheet.radius", "curve"], ["sheet.closed", "closed"], ["sheet.nodes_y", "rows"],
  ["casing.radius", "casing"], ["casing.window_angle", "windowHalfAngle"], ["casing.window_place", "windowHalfY"], ["sheet", "nodes"],
];

/** What the form says, and what the picture shows: the last scene that was taken. */
let choices: Choices = { ...DEFAULTS };
let shown = choices;
let number = 0;
/** Whether the form's scene was refused: the picture of the last one stays, and stands still. */
let refused = false;
/** Whether the scene runs as soon as it is seen. */
let playing = false;
let running = false;
let dt = 1;
let history: Row[] = [];
let frame: Frame | undefined;
let rest: Rest | undefined;
/** How the run ended, and its last row. */
let end: { rest: Rest; row: Row } | undefined;
let speed: Speed | undefined;
/** The row that was asked for last, and whether an answer is due. */
let wanted: number | undefined;
let waiting = false;
/** Outcomes so far. */
let latched: string[] = [];
/** What of the address was left out, in words. */
let leftOut = "";

const program = URL.createObjectURL(new Blob([workerText], { type: "text/javascript" }));
const worker = new Worker(program);
const tell = (message: ToWorker): void => worker.postMessage(message);

// The worker unpacks the kernel and makes the first scene while the page sets up its picture: beginPicture, at the end of this file.
tell({ kind: "kernel", packed: kernelText });
tell({ kind: "pace", pace: Number(pace.value) });

let view: View | undefined;

const plots = element("plots", HTMLElement);
const axis: Axis<Row> = { unit: "µs", of: (row) => 1e6 * row.time_s, chosen: (time) => goTo(Math.round((1e-6 * time) / (ROW * dt))) };
const PLOTS = [
  new Plot(plots, "Velocity normal to the sheet", "m/s", [{ name: "normal", colour: "--a", of: (row) => row.velocity_z_m_per_s }], axis),
  new Plot(plots, "Force normal to the sheet, mean of 64 steps", "N", [{ name: "force", colour: "--b", of: (row) => -row.force_z_n }], axis),
  new Plot(plots, "Energy absorbed", "J", [
    { name: "all", colour: "--a", of: (row) => row.absorbed_j },
    { name: "strain", colour: "--b", of: (row) => row.strain_j },
    { name: "kinetic", colour: "--c", of: (row) => row.fabric_kinetic_j },
    { name: "rupture", colour: "--d", of: (row) => row.dissipated_j },
    { name: "contact loss and friction", colour: "--e", of: (row) => row.contact_loss_j + row.friction_j },
    { name: "viscous", colour: "--f", of: (row) => row.viscous_j },
  ], axis),
  new Plot(plots, "Energy residual", "% of the impact", [{ name: "residual", colour: "--d", of: (row) => (100 * row.energy_residual_j) / Math.max(history[0]?.projectile_kinetic_j ?? 1, 1e-12) }], axis),
];
const limit = element("limit", HTMLElement);
const residuals = new Plot<Shot>(limit, "Residual over impact velocity", "m/s", [{ name: "residual", colour: "--a", of: (shot) => shot.residual }], { unit: "m/s", of: (shot) => shot.speed, chosen: (speed) => shootAt(Math.round(speed)), dots: true });
swift.before(residuals.figure);
const curve = new Curve(() => new Worker(program), { kind: "kernel", packed: kernelText }, () => drawCurve());

const VALUES = {
  time: "Time", velocity: "Velocity normal to the sheet", absorbed: "Energy absorbed", peak: "Peak force (mean of 1 µs)", failed: "Failed segments",
  balance: "Energy balance", outcomes: "Outcomes", digest: "Digest here", end: "Digest at the end", native: "Native library's at the end", same: "Same bits", speed: "Speed of the steps", slower: "Slower than reality",
};
const values = Object.fromEntries(
  Object.entries(VALUES).map(([id, words]) => {
    const [group, name, value] = [document.createElement("div"), document.createElement("dt"), document.createElement("dd")];
    name.textContent = words;
    value.id = `value-${id}`;
    group.append(name, value);
    element(["digest", "end", "native", "same"].includes(id) ? "digests" : "values", HTMLElement).append(group);
    return [id, value];
  }),
) as Record<keyof typeof VALUES, HTMLElement>;

const microseconds = (row: number): string => `${(1e6 * row * ROW * dt).toFixed(1)} µs`;
const inWords = (shape: Shape): string => (shape === "disc_sector" ? "disc sector" : shape === "fsp" ? "fragment simulator" : shape);

// The form.

const inputs = [...form.elements].filter((one): one is HTMLInputElement | HTMLSelectElement => one instanceof HTMLInputElement || one instanceof HTMLSelectElement);

/** What the form says, or the field that it does not say it in. */
function read(): Choices | { field: keyof Choices; text: string } {
  const found: Choices = { ...choices };
  for (const input of inputs) {
    const key = input.name as keyof Choices;
    if (input instanceof HTMLSelectElement) {
      Object.assign(found, { [key]: input.value });
      continue;
    }
    if (!shownBy(key, found.shape)) continue;
    const [least, most] = LIMITS[key] ?? [-Infinity, Infinity];
    const value = input.valueAsNumber;
    const label = input.labels?.[0]?.textContent ?? key;
    if (!Number.isFinite(value)) return { field: key, text: `${label}: enter a number.` };
    if (WHOLE.includes(key) && !Number.isInteger(value)) return { field: key, text: `${label}: enter a whole number.` };
    if (value < least || value > most) return { field: key, text: `${label}: this page takes ${least} to ${most}.` };
    Object.assign(found, { [key]: value });
  }
  if (found.curve > 0 && Math.abs(found.x) + 1e3 * ball(found) >= found.curve) {
    return { field: "curve", text: `The ${inWords(found.shape)} does not fit into a circle of ${found.curve} mm.` };
  }
  if (misses(found)) {
    const field = found.curve === 0 && Math.abs(found.x) > Math.abs(found.y) ? "x" : "y";
    const half = 1e3 * extent(found)[1][field === "x" ? 0 : 1];
    return { field, text: `The ${inWords(found.shape)} does not meet the sheet, which reaches ${half.toFixed(1)} mm to each side of its middle.` };
  }
  return found;
}

/** Whether a shape reads a dimension. */
function shownBy(key: keyof Choices, shape: Shape): boolean {
  const some = Object.values(DIMENSIONS).some((keys) => keys.includes(key));
  return !some || DIMENSIONS[shape].includes(key);
}

function write(): void {
  for (const input of inputs) input.value = String(choices[input.name as keyof Choices]);
  fit();
}

/** What follows from the choices on the page around the form. */
function fit(): void {
  for (const input of inputs) {
    const field = input.closest<HTMLElement>(".field");
    if (field) field.hidden = !shownBy(input.name as keyof Choices, choices.shape);
  }
  const label = (id: string, text: string): void => void (form.querySelector(`label[for=${id}]`)!.textContent = text);
  label("length", choices.shape === "disc_sector" ? "Thickness, mm" : choices.shape === "box" ? "Edge along z, mm" : "Length, mm");
  label("radius", choices.shape === "disc_sector" ? "Radius of the rim, mm" : "Radius, mm");
  const [width = 0, length = 0] = extent(choices)[1].map((half) => (2e3 * half).toFixed(0));
  const [across, along, closed] = [choices.nodes, rows(choices), choices.closed === "yes"];
  const segments = along * (closed ? across : across - 1) + across * (along - 1);
  element("size", HTMLElement).textContent = `${width} x ${length} mm, ${segments.toLocaleString("en")} yarn segments${closed ? `; a row closes to a ring at a radius of ${closing(choices).toFixed(6)} mm` : ""}`;
  named.value = nameOf(choices) ?? "";
}

/** Says what is wrong, at the field; what belongs to none, under the form. */
function complain(field: string, text: string): void {
  const more = element("more", HTMLDetailsElement);
  const place = inputs.find((input) => input.name === field)?.closest(".field");
  (place ?? more).after(problem);
  if (place) more.open = true;
  problem.textContent = `${text} ${leftOut}`.trim();
  for (const input of inputs) {
    const bad = input.name === field;
    if (bad) {
      input.setAttribute("aria-invalid", "true");
      input.setAttribute("aria-describedby", "problem");
    } else {
      input.removeAttribute("aria-invalid");
      input.removeAttribute("aria-describedby");
    }
  }
  refused = text !== "";
  element("transport", HTMLFieldSetElement).disabled = search.disabled = refused;
}

/** Leaves the scene before: what the worker still says of it is not heard. Its picture and results stay until there is another. */
function leave(): void {
  number += 1;
  [wanted, waiting, running] = [undefined, false, false];
}

/** Says why there is no scene. */
function refuse(field: string, text: string, who: string): void {
  leave();
  tell({ kind: "pause" });
  curve.stop();
  complain(field, text);
  outcome.textContent = `${who} refuses this scene.${frame ? " The picture is that of the scene before." : ""}`;
  update();
}

/** Takes the choices up: a new scene in the worker, and in the address. */
function take(play = false): void {
  leave();
  complain("", "");
  fit();
  playing = play;
  const address = toAddress(choices);
  window.history.replaceState(null, "", `#${address}`);
  tell({ kind: "scene", number, fabric: choices.fabric, values: assignments(choices) });
}

form.addEventListener("submit", (event) => event.preventDefault());
form.addEventListener("change", () => {
  leftOut = "";
  const found = read();
  if ("text" in found) return refuse(found.field, found.text, "The page");
  choices = found;
  take();
});
named.append(...[{ name: "", title: "your own" }, ...NAMED].map(({ name, title }) => new Option(title, name)));
named.addEventListener("change", () => {
  const scene = NAMED.find(({ name }) => name === named.value);
  if (!scene) return fit();
  leftOut = "";
  choices = { ...DEFAULTS, ...scene.changes };
  write();
  take();
});
window.addEventListener("hashchange", () => open());

/** Takes the scene of the address; without one the first with a name, which runs by itself where the reader does not mind motion. */
function open(): void {
  if (location.hash.length < 2) {
    choices = { ...DEFAULTS, ...NAMED[0]?.changes };
    write();
    return take(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  }
  const { choices: found, unknown } = fromAddress(location.hash.slice(1));
  choices = found;
  write();
  // Every default is good beside any other good value, so this ends.
  for (let checked = read(); "text" in checked; checked = read()) {
    const { field, text } = checked;
    unknown.push(`${field}=${choices[field]} (${text.replace(/\.$/, "")})`);
    choices = { ...choices, [field]: DEFAULTS[field] };
    write();
  }
  leftOut = unknown.length > 0 ? `Left out of the link: ${unknown.join(", ")}. The defaults stand in their place.` : "";
  take();
}

// Time.

function goTo(row: number): void {
  wanted = Math.max(0, row);
  if (refused || waiting || history.length === 0) return;
  waiting = true;
  tell({ kind: "go", row: wanted });
}

runButton.addEventListener("click", () => {
  if (running) tell({ kind: "pause" });
  else play();
});
function play(): void {
  tell({ kind: "run", anew: again() });
  [running, playing, end, wanted] = [true, false, undefined, undefined];
  outcome.textContent = "Running ...";
  update();
}

/** Whether the run has ended, and the picture is where the page went then, or at the end. */
function again(): boolean {
  return end !== undefined && (frame?.row === deepest() || rest?.ended !== "");
}

/** The row at which the held sheet is deepest; the last if it stays where it is. */
function deepest(): number {
  if (history.every((row) => row.max_deflection_m === 0)) return history.length - 1;
  return history.reduce((best, row, k) => (row.max_deflection_m > (history[best]?.max_deflection_m ?? 0) ? k : best), 0);
}
element("step", HTMLButtonElement).addEventListener("click", () => goTo((frame?.row ?? 0) + 1));
element("back", HTMLButtonElement).addEventListener("click", () => goTo((frame?.row ?? 0) - 1));
element("start", HTMLButtonElement).addEventListener("click", () => goTo(0));
time.addEventListener("input", () => goTo(time.valueAsNumber));
pace.addEventListener("change", () => tell({ kind: "pace", pace: Number(pace.value) }));
colouring.addEventListener("change", () => show());
side.addEventListener("change", () => view?.look(side.value as Side));

// What the worker says.

worker.onmessage = ({ data }: MessageEvent<FromWorker>): void => {
  if ("number" in data && data.number !== undefined && data.number !== number) return;
  switch (data.kind) {
    case "begun":
      return beginPicture();
    case "ready":
      element("version", HTMLElement).textContent = `Version ${data.version}.`;
      return;
    case "made":
      dt = data.dt;
      shown = choices;
      swift.max = String(Math.ceil(curve.take(shown) ? 2 * shown.speed : Math.max(Number(swift.max), shown.speed)));
      swift.value = String(shown.speed);
      [history, frame, rest, speed, end] = [[], undefined, undefined, undefined, undefined];
      view?.make(data.nodes, shown, side.value as Side);
      return;
    case "refused": {
      const [, field = ""] = FIELDS.find(([start]) => data.field.startsWith(start)) ?? [];
      // Of a box the least edge is refused.
      const least = (["edgeX", "edgeY", "length"] as const).reduce((a, b) => (choices[b] < choices[a] ? b : a));
      return refuse(field === "edgeX" ? least : field, data.text, "The kernel");
    }
    case "failed":
      running = false;
      waiting = false;
      outcome.textContent = `The run failed: ${data.text}`;
      return update();
    case "shown":
      history.push(...data.rows);
      ({ frame, speed, rest, running, latched } = data);
      if (running && latched.includes("detached")) outcome.textContent = "Running: only torn cloth is touched now. Pause when you like.";
      waiting = false;
      if (rest?.ended && !end) {
        finish(rest);
        wanted = deepest();
      } else if (rest && !end) {
        outcome.textContent = frame.row > 0 ? `Stopped at ${microseconds(frame.row)}.` : `Ready: ${inWords(shown.shape)} at ${shown.speed} m/s. Press Run.`;
      }
      show();
      if (wanted !== undefined && wanted !== frame.row && !running && (wanted < frame.row || !rest?.ended)) {
        goTo(wanted);
      } else {
        wanted = undefined;
      }
      void Promise.resolve(view?.drawn()).then(() => {
        if (picture.dataset.row === undefined) performance.mark("first picture");
        // The graphics processor may report an earlier picture after a later one.
        if (data.frame === frame) picture.dataset.row = String(data.frame.row);
        tell({ kind: "drawn" });
        if (playing && data.number === number) play();
      });
      return;
    case "checked":
      return checked(data.digests, data.seconds);
    case "replayed":
      element("replayed", HTMLElement).textContent = data.text;
      return;
  }
};

/** The end of a run, in words; it is a point of the curve, too. */
function finish(last: Rest): void {
  const row = history[history.length - 1];
  if (!row) return;
  end = { rest: last, row };
  const { ended } = last;
  const at = `at ${microseconds(history.length - 1)}`;
  const fast = Math.hypot(row.velocity_x_m_per_s, row.velocity_y_m_per_s, row.velocity_z_m_per_s);
  const through = ended.includes("exited");
  card.textContent = ended.includes("arrested") ? "Stopped" : through ? `Through at ${fast.toFixed(0)} m/s` : ended === "passed" ? "Passed by" : "Not decided";
  if (through || ended.includes("arrested")) curve.add({ speed: shown.speed, through, residual: through ? fast : 0 });
  const residual = `velocity ${row.velocity_z_m_per_s.toFixed(1)} m/s, ${row.absorbed_j.toFixed(2)} J absorbed`;
  const name = ended.charAt(0).toUpperCase() + ended.slice(1);
  const open = Math.abs(row.energy_residual_j) > 0.01 * (history[0]?.projectile_kinetic_j ?? 0) ? "The energy residual exceeds 1 % of the impact energy: slack yarn changes the energy, see \"Slack and taut\" in docs/model.md. " : "";
  outcome.textContent = `${name} ${at}: ${residual}. ${open} ${latched.includes("detached") ? "The sheet has torn off. " : ""}The picture: the sheet at its deepest.`;
}

/** Whether this end has the native library's digest; undefined where there is none to compare. */
function sameBits(): boolean | undefined {
  const pin = native[nameOf(shown) ?? ""];
  return end && pin ? end.rest.digest === pin.digest : undefined;
}

/** Strain at which the yarn begins to fail. */
function critical(): number {
  return parameter(shown.fabric, "yarn.critical_stretch") - 1;
}

function show(): void {
  if (frame) view?.show(frame, colouring.value as Colouring, critical());
  element("most", HTMLElement).textContent = colouring.value === "stretch" ? `strain ${(100 * critical()).toFixed(2)} %` : "failed";
  update();
}

function update(): void {
  runButton.textContent = running ? "Pause" : again() ? "Run again" : "Run";
  card.hidden = !end;
  drawCurve();
  const row = frame && history[frame.row];
  if (!frame || !row) {
    for (const value of Object.values(values)) [value.textContent, value.className] = ["-", ""];
    element("clock", HTMLElement).textContent = "";
    for (const plot of PLOTS) plot.draw([], 0);
    return;
  }
  time.max = String(history.length - 1);
  time.value = String(frame.row);
  time.setAttribute("aria-valuetext", microseconds(frame.row));
  const { failed_segments: failed } = row;
  element("clock", HTMLElement).textContent = `${microseconds(frame.row)}\n${row.velocity_z_m_per_s.toFixed(1)} m/s\n${failed} failed`;
  picture.setAttribute("aria-label", `The sheet at ${microseconds(frame.row)}: deflection ${(1e3 * row.max_deflection_m).toFixed(1)} mm, ${failed} failed segments, ${inWords(shown.shape)} at ${(1e3 * row.position_z_m).toFixed(1)} mm`);

  const start = history[0]?.projectile_kinetic_j ?? 0;
  const captions = whatIsSeen();
  const seen = captions.filter(([at]) => at <= (frame?.row ?? 0)).length;
  element("captions", HTMLElement).replaceChildren(...captions.map(([at, words], k) => {
    const item = document.createElement("li");
    item.textContent = `${microseconds(at)}: ${words}`;
    item.className = k === seen - 1 ? "now" : "";
    return item;
  }));
  const pin = native[nameOf(shown) ?? ""];
  values.time.textContent = `${microseconds(frame.row)}, step ${row.step.toLocaleString("en")}`;
  values.velocity.textContent = `${row.velocity_z_m_per_s.toFixed(3)} m/s`;
  values.absorbed.textContent = `${row.absorbed_j.toFixed(4)} J of ${start.toFixed(2)} J${row.support_work_j > 0 ? `, ${row.support_work_j.toFixed(4)} J of it by held nodes` : ""}`;
  values.peak.textContent = `${frame.peakForce.toFixed(1)} N`;
  values.failed.textContent = failed.toLocaleString("en");
  const open = row.energy_residual_j / Math.max(start, 1e-12);
  values.balance.textContent = `residual ${(100 * open).toFixed(4)} %${Math.abs(open) > 0.01 ? ": slack yarn changes the energy" : ""}`;
  values.outcomes.textContent = latched.join(", ") || "none yet";
  values.digest.textContent = rest?.digest ?? "at the next stop";
  values.end.textContent = end?.rest.digest ?? "at the end";
  values.native.textContent = pin ? pin.digest : "run the TOML natively";
  const same = sameBits();
  values.same.textContent = same === undefined ? (pin ? "compared at the end" : "own scene") : same ? "yes" : "NO";
  values.same.className = same === undefined ? "" : same ? "yes" : "no";
  values.speed.textContent = speed ? `${speed.nanosecondsPerNodeStep.toFixed(2)} ns per node-step` : "not run yet";
  values.slower.textContent = speed ? `${Math.round(speed.slowerThanReality).toLocaleString("en")} times` : "not run yet";
  for (const plot of PLOTS) plot.draw(history, 1e6 * row.time_s);
}

/** What is seen, and from which row on. */
function whatIsSeen(): [number, string][] {
  const start = history[0]?.velocity_z_m_per_s ?? 0;
  const fails = history.findIndex((row) => row.failed_segments > 0);
  const last: [number, string] = fails >= 0 ? [fails, "The first yarns fail, and a hole opens."] : [history.some((row) => row.velocity_z_m_per_s <= 0) ? deepest() : -1, "The sheet holds: it is at its deepest, and throws the fragment back."];
  const all: [number, string][] = [
    [0, `The ${inWords(shown.shape)} of ${Number(mass(shown).toPrecision(4))} g comes at ${shown.speed} m/s. Strain, in colour, runs out along the yarns it hits.`],
    [history.findIndex((row) => row.velocity_z_m_per_s < 0.95 * start), "It has lost 5 % of its velocity: the cloth around it moves with it, in a pyramid."],
    last,
  ];
  return all.filter(([row]) => row >= 0).sort(([a], [b]) => a - b);
}

// The limit.

function shootAt(speed: number): void {
  if (refused || speed < 1) return;
  choices = { ...choices, speed };
  write();
  take(true);
}
swift.addEventListener("input", () => drawCurve());
swift.addEventListener("change", () => shootAt(swift.valueAsNumber));
search.addEventListener("click", () => (curve.busy ? curve.stop() : curve.begin(shown)));

function drawCurve(): void {
  const { shots, busy, problem } = curve;
  swift.max = String(Math.max(Number(swift.max), ...shots.map(({ speed }) => Math.ceil(speed))));
  swift.disabled = refused;
  swift.setAttribute("aria-valuetext", `${swift.value} m/s`);
  residuals.draw(shots, swift.valueAsNumber, Number(swift.max));
  const [low, high] = bracket(shots);
  const between = high < Infinity && low > 0 ? `Limit: through at ${high} m/s, not at ${low} m/s.` : shots.length > 0 ? `${high < Infinity ? `Through at ${high}` : `Not through at ${low}`} m/s.` : "";
  search.textContent = busy ? "Stop" : "Find the limit";
  element("found", HTMLElement).textContent = `Impact at ${swift.value} m/s. ${between} ${busy ? `${shots.length} shots ...` : ""} ${problem}`.replace(/ +/g, " ").trim();
}

// The targets' test scenes.

element("check", HTMLButtonElement).addEventListener("click", () => {
  element("checked", HTMLElement).textContent = "Running ...";
  tell({ kind: "check" });
});

/** A capsule that is dropped anywhere on the page, or chosen. */
async function replay(file: File | undefined): Promise<void> {
  if (!file) return;
  element("fold", HTMLDetailsElement).open = true;
  element("replayed", HTMLElement).textContent = "Replaying ...";
  tell({ kind: "replay", file: new Uint8Array(await file.arrayBuffer()) });
}
document.addEventListener("dragover", (event) => event.preventDefault());
document.addEventListener("drop", (event) => {
  event.preventDefault();
  void replay(event.dataTransfer?.files[0]);
});
const capsule = element("capsule", HTMLInputElement);
capsule.addEventListener("change", () => void replay(capsule.files?.[0]));

function checked(digests: Record<string, string>, seconds: number): void {
  const rows = Object.entries(pinned);
  const equal = rows.filter(([name, digest]) => digests[name] === digest).length;
  element("checked", HTMLElement).textContent = `${equal} of ${rows.length} scenes have the bits of every other target (${seconds.toFixed(2)} s).`;
  const table = document.createElement("table");
  const line = (kind: "th" | "td", cells: string[]): void => {
    const row = table.insertRow();
    for (const text of cells) {
      const cell = document.createElement(kind);
      cell.textContent = text;
      row.append(cell);
    }
  };
  line("th", ["scene", "pinned", "here"]);
  for (const [name, digest] of rows) line("td", [name, digest, digests[name] === digest ? "the same" : (digests[name] ?? "missing")]);
  element("pinned", HTMLElement).replaceChildren(table);
}

// Taking things away.

function save(name: string, text: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
element("toml", HTMLButtonElement).addEventListener("click", () => save("fabric-scene.toml", toToml(choices)));
element("csv", HTMLButtonElement).addEventListener("click", () => {
  const lines = history.map((row) => COLUMNS.map((column) => row[column]).join(","));
  save("history.csv", [COLUMNS.join(","), ...lines].join("\n") + "\n");
});
element("link", HTMLButtonElement).addEventListener("click", (event) => {
  const button = event.currentTarget as HTMLButtonElement;
  const said = (text: string): void => {
    button.textContent = text;
    setTimeout(() => (button.textContent = "Copy link"), 2000);
  };
  const copied = navigator.clipboard?.writeText(location.href) ?? Promise.reject(new Error("no clipboard"));
  copied.then(() => said("Copied"), () => said("Copy the address above"));
});

// Start.

/** Sets up WebGL. That keeps the page busy until the browser's graphics have started, and a page that is busy starts no worker: so the
 * worker goes first. */
function beginPicture(): void {
  try {
    view = new View(picture);
  } catch {
    const note = element("nopicture", HTMLElement);
    note.textContent = "This browser has no WebGL, so there is no picture. Everything else works.";
    note.hidden = false;
  }
}

if (matchMedia("(max-width: 860px)").matches) element("more", HTMLDetailsElement).open = false;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => update());
new ResizeObserver(() => update()).observe(plots);
open();
