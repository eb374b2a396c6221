/** The page: form, picture, plots and results. The worker computes. */
import { native, pinned } from "built:data";
import kernelText from "built:kernel";
import workerText from "built:worker";
import { COLUMNS, ROW } from "./messages";
import type { Frame, FromWorker, Rest, Row, Speed, ToWorker } from "./messages";
import { Plot } from "./plots";
import { DEFAULTS, DIMENSIONS, NAMED, assignments, changesOf, fromAddress, misses, nameOf, spacing, toAddress, toToml } from "./scene";
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
const outcome = element("outcome", HTMLElement);
const problem = element("problem", HTMLElement);

/** Least and most of what the page itself limits: 501 x 501 nodes take some 60 MB. */
const LIMITS: Partial<Record<keyof Choices, [number, number]>> = { nodes: [11, 501], seed: [0, Number.MAX_SAFE_INTEGER], bore: [0, 1e3], oblique: [-80, 80], speed: [0.1, 1e6], mass: [1e-3, 1e6] };
const WHOLE: (keyof Choices)[] = ["nodes", "seed"];
/** The field of the form that a parameter of the kernel comes from, and the parameter's unit in the kernel. */
const FIELDS: [string, keyof Choices, string][] = [
  ["projectile.sector.inner_radius", "bore", "m"], ["projectile.sector.outer_radius", "radius", "m"], ["projectile.sector.angle", "angle", "rad"],
  ["projectile.sector.thickness", "length", "m"], ["projectile.radius", "radius", "m"], ["projectile.length", "length", "m"], ["projectile.mass", "mass", "kg"],
  ["projectile.velocity", "speed", "m/s"], ["contact.friction", "friction", ""], ["projectile.position", "x", "m"], ["projectile.orientation", "tiltX", ""],
  ["attachment", "attachment", ""], ["sheet", "nodes", ""],
];

/** What the page shows now. */
let choices: Choices = { ...DEFAULTS };
let number = 0;
let running = false;
let dt = 1;
let history: Row[] = [];
let frame: Frame | undefined;
let rest: Rest | undefined;
let speed: Speed | undefined;
/** The row that was asked for last, and whether an answer is due. */
let wanted: number | undefined;
let waiting = false;
/** Outcomes so far. */
let latched: string[] = [];
/** What of the address was left out, in words. */
let leftOut = "";

const worker = new Worker(URL.createObjectURL(new Blob([workerText], { type: "text/javascript" })));
const tell = (message: ToWorker): void => worker.postMessage(message);

// The worker unpacks the kernel and makes the first scene while the page sets up its picture: beginPicture, at the end of this file.
tell({ kind: "kernel", packed: kernelText });
tell({ kind: "pace", pace: Number(pace.value) });

let view: View | undefined;

const plots = element("plots", HTMLElement);
const atTime = (seconds: number): void => goTo(Math.round(seconds / (ROW * dt)));
const PLOTS = [
  new Plot(plots, "Velocity normal to the sheet", "m/s", [{ name: "normal", colour: "--a", of: (row) => row.velocity_z_m_per_s }], atTime),
  new Plot(plots, "Force normal to the sheet, mean of 64 steps", "N", [{ name: "force", colour: "--b", of: (row) => -row.force_z_n }], atTime),
  new Plot(plots, "Energy absorbed", "J", [
    { name: "all", colour: "--a", of: (row) => row.contact_work_j },
    { name: "strain", colour: "--b", of: (row) => row.strain_j },
    { name: "kinetic", colour: "--c", of: (row) => row.fabric_kinetic_j },
    { name: "rupture", colour: "--d", of: (row) => row.dissipated_j },
    { name: "contact loss and friction", colour: "--e", of: (row) => row.contact_loss_j + row.friction_j },
    { name: "viscous", colour: "--f", of: (row) => row.viscous_j },
  ], atTime),
  new Plot(plots, "Energy balance: what does not close", "% of the impact", [{ name: "residual", colour: "--d", of: (row) => (100 * row.energy_residual_j) / Math.max(history[0]?.projectile_kinetic_j ?? 1, 1e-12) }], atTime),
];

const VALUES = {
  time: "Time", velocity: "Velocity normal to the sheet", absorbed: "Energy absorbed", peak: "Peak force (mean of 1 µs)", failed: "Failed segments",
  balance: "Energy balance", outcomes: "Outcomes", digest: "Digest here", native: "Digest, native library", same: "Same bits", speed: "Speed of the steps", slower: "Slower than reality",
};
const values = Object.fromEntries(
  Object.entries(VALUES).map(([id, words]) => {
    const [group, name, value] = [document.createElement("div"), document.createElement("dt"), document.createElement("dd")];
    name.textContent = words;
    value.id = `value-${id}`;
    group.append(name, value);
    element("values", HTMLElement).append(group);
    return [id, value];
  }),
) as Record<keyof typeof VALUES, HTMLElement>;

const microseconds = (row: number): string => `${(1e6 * row * ROW * dt).toFixed(1)} µs`;
const inWords = (shape: Shape): string => (shape === "disc_sector" ? "disc sector" : shape);

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
  if (misses(found)) {
    const half = 500 * (found.nodes - 1) * spacing(found.fabric);
    const field = Math.abs(found.x) > Math.abs(found.y) ? "x" : "y";
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
  label("length", choices.shape === "disc_sector" ? "Thickness, mm" : "Length, mm");
  label("radius", choices.shape === "disc_sector" ? "Radius of the rim, mm" : "Radius, mm");
  const millimetres = 1e3 * (choices.nodes - 1) * spacing(choices.fabric);
  element("size", HTMLElement).textContent = `${millimetres.toFixed(0)} x ${millimetres.toFixed(0)} mm, ${(2 * choices.nodes * (choices.nodes - 1)).toLocaleString("en")} yarn segments`;
  named.value = nameOf(choices) ?? "";
}

function complain(field: string, text: string): void {
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
  runButton.disabled = text !== "";
}

/** Gives up the scene before: what the worker still says of it is not heard. */
function drop(): void {
  number += 1;
  [history, frame, rest, speed, wanted, waiting, running] = [[], undefined, undefined, undefined, undefined, false, false];
}

/** Says why there is no scene, and shows none: the results of the scene before are not those of the form. */
function refuse(field: string, text: string, who: string): void {
  drop();
  tell({ kind: "pause" });
  complain(field, text);
  outcome.textContent = `${who} refuses this scene.`;
  view?.hide();
  update();
}

/** Takes the choices up: a new scene in the worker, and in the address. */
function take(): void {
  drop();
  complain("", "");
  fit();
  const address = toAddress(choices);
  window.history.replaceState(null, "", address === "" ? location.pathname + location.search : `#${address}`);
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

/** Takes the scene of the address. */
function open(): void {
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
  if (waiting || history.length === 0) return;
  waiting = true;
  tell({ kind: "go", row: wanted });
}

runButton.addEventListener("click", () => {
  if (running) return tell({ kind: "pause" });
  tell({ kind: "run" });
  running = true;
  outcome.textContent = "Running ...";
  update();
});
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
      view?.make(data.nodes, (data.nodes[0] - 1) * spacing(choices.fabric), choices, side.value as Side);
      return;
    case "refused": {
      const [, field = "", unit = ""] = FIELDS.find(([start]) => data.field.startsWith(start)) ?? [];
      return refuse(field, data.text.replace(/; it is \S+$/, (value) => `${value} ${unit}`).trim(), "The kernel");
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
      show();
      if (rest) announce(rest);
      if (wanted !== undefined && wanted !== frame.row && !running && (wanted < frame.row || !rest?.ended)) {
        goTo(wanted);
      } else {
        wanted = undefined;
      }
      void Promise.resolve(view?.drawn()).then(() => {
        if (picture.dataset.row === undefined) performance.mark("first picture");
        picture.dataset.row = String(data.frame.row);
        tell({ kind: "drawn" });
      });
      return;
    case "checked":
      return checked(data.digests, data.seconds);
  }
};

/** What came out, in words. */
function announce({ ended }: Rest): void {
  const row = frame && history[frame.row];
  if (!row) return;
  const at = `at ${microseconds(frame?.row ?? 0)}`;
  if (ended === "") {
    outcome.textContent = row.step > 0 ? `Stopped ${at}.` : `Ready: ${inWords(choices.shape)} at ${choices.speed} m/s. Press Run.`;
    return;
  }
  const residual = `velocity ${row.velocity_z_m_per_s.toFixed(1)} m/s, ${row.contact_work_j.toFixed(2)} J absorbed`;
  const name = ended.charAt(0).toUpperCase() + ended.slice(1);
  const open = Math.abs(row.energy_residual_j) > 0.01 * (history[0]?.projectile_kinetic_j ?? 0) ? "The energy balance is open by more than 1 %: slack yarn adds energy, see \"Slack and taut\" in docs/model.md. " : "";
  outcome.textContent = `${name} ${at}: ${residual}. ${open} ${latched.includes("detached") ? "The sheet has torn off. " : ""}${sameBits() === true ? "Same bits as the native library." : ""}`;
}

/** Whether this end has the native library's digest; undefined where there is none to compare. */
function sameBits(): boolean | undefined {
  const name = nameOf(choices);
  const pin = name === undefined ? undefined : native[name];
  return rest?.ended && pin ? rest.digest === pin.digest : undefined;
}

/** Strain at which the yarn begins to fail. */
function critical(): number {
  return (changesOf(choices.fabric)["yarn.critical_stretch"]?.[0] ?? 1.03) - 1;
}

function show(): void {
  if (frame) view?.show(frame, colouring.value as Colouring, critical());
  element("most", HTMLElement).textContent = colouring.value === "stretch" ? `strain ${(100 * critical()).toFixed(2)} %` : "failed";
  update();
}

function update(): void {
  runButton.textContent = running ? "Pause" : rest?.ended ? "Run again" : "Run";
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
  picture.setAttribute("aria-label", `The sheet at ${microseconds(frame.row)}: deflection ${(1e3 * row.max_deflection_m).toFixed(1)} mm, ${failed} failed segments, ${inWords(choices.shape)} at ${(1e3 * row.position_z_m).toFixed(1)} mm`);

  const start = history[0]?.projectile_kinetic_j ?? 0;
  const pin = native[nameOf(choices) ?? ""];
  values.time.textContent = `${microseconds(frame.row)}, step ${row.step.toLocaleString("en")}`;
  values.velocity.textContent = `${row.velocity_z_m_per_s.toFixed(3)} m/s`;
  values.absorbed.textContent = `${row.contact_work_j.toFixed(4)} J of ${start.toFixed(2)} J${row.support_work_j > 0 ? `, ${row.support_work_j.toFixed(4)} J of it by held nodes` : ""}`;
  values.peak.textContent = `${frame.peakForce.toFixed(1)} N`;
  values.failed.textContent = failed.toLocaleString("en");
  const open = row.energy_residual_j / Math.max(start, 1e-12);
  values.balance.textContent = `open by ${(100 * open).toFixed(4)} %${Math.abs(open) > 0.01 ? ": slack yarn adds energy" : ""}`;
  values.outcomes.textContent = latched.join(", ") || "none yet";
  values.digest.textContent = rest?.digest ?? "at the next stop";
  values.native.textContent = pin ? `${pin.digest} at the end` : "run the TOML natively";
  const same = sameBits();
  values.same.textContent = same === undefined ? (pin ? "compared at the end" : "own scene") : same ? "yes" : "NO";
  values.same.className = same === undefined ? "" : same ? "yes" : "no";
  values.speed.textContent = speed ? `${speed.nanosecondsPerNodeStep.toFixed(2)} ns per node-step` : "not run yet";
  values.slower.textContent = speed ? `${Math.round(speed.slowerThanReality).toLocaleString("en")} times` : "not run yet";
  for (const plot of PLOTS) plot.draw(history, frame.row);
}

// The targets' test scenes.

element("check", HTMLButtonElement).addEventListener("click", () => {
  element("checked", HTMLElement).textContent = "Running ...";
  tell({ kind: "check" });
});

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
