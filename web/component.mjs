// The FMU's component for WebAssembly in a page, made a program of JavaScript by jco.
import { readFileSync } from "node:fs";
import { transpileBytes } from "@bytecodealliance/jco-transpile";
import { transform } from "esbuild";

const description = readFileSync(new URL("../modelDescription/fmi3.xml", import.meta.url), "utf8");
const reference = (name) => Number(description.match(new RegExp(`name="${name.replaceAll(".", "\\.")}" valueReference="(\\d+)"`))[1]);
const token = description.match(/instantiationToken="([^"]*)"/)[1];

/** Runs 40 communication steps in event mode, goes back to the 20th by a state as bytes, and does the rest again: the log, the events, and
 * whether both ends have the same bytes. */
export async function run(page, file) {
  const { files, imports } = await transpileBytes(readFileSync(file), { name: "component", instantiation: "async" });
  const program = await transform(new TextDecoder().decode(files["component.js"]), { format: "iife", globalName: "component", target: "es2022", logLevel: "error" });
  await page.addScriptTag({ content: program.code });
  const modules = Object.entries(files).filter(([name]) => name.endsWith(".wasm"));
  const refs = Object.fromEntries(["sheet.nodes_x", "sheet.nodes_y", "projectile.start.position", "capsule"].map((name) => [name, reference(name)]));
  const done = await page.evaluate(
    async ([modules, token, refs]) => {
      const log = [];
      const say = (name, status, category, message) => void log.push([name, status, category, message]);
      const bytes = Object.fromEntries(modules.map(([name, code]) => [name, Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0))]));
      const instance = await component.instantiate((name) => WebAssembly.compile(bytes[name]), { "fmi:fmi3/callbacks": { logMessage: say } });
      const { CoSimulationInstance } = instance.coSimulation;
      const refused = CoSimulationInstance.instantiateCoSimulation("page", "another", false, true, true, true, new Uint32Array());
      const fmu = CoSimulationInstance.instantiateCoSimulation("page", token, false, true, true, true, new Uint32Array());
      const said = [
        fmu.enterStepMode(),
        fmu.setInt32([refs["sheet.nodes_x"], refs["sheet.nodes_y"]], [41, 41]),
        fmu.setFloat64([refs["projectile.start.position"]], [0, 0, -0.01906]),
        fmu.setBoolean([refs.capsule], [true]),
        fmu.enterInitializationMode(undefined, 0, undefined),
        fmu.exitInitializationMode(),
        fmu.enterStepMode(),
      ];
      const events = [];
      const go = (t, end) => {
        while (t < end - 1e-12) {
          const step = fmu.doStep(t, Math.min(1e-6, end - t), true);
          t = step.lastSuccessfulTime;
          if (!step.eventHandlingNeeded) continue;
          said.push(fmu.enterEventMode());
          events.push([t, fmu.updateDiscreteStates().terminateSimulation]);
          said.push(fmu.enterStepMode());
        }
        return t;
      };
      const middle = go(0, 20e-6);
      const saved = fmu.getFmuState();
      go(middle, 40e-6);
      const end = fmu.getFmuState();
      said.push(fmu.setFmuState(saved));
      go(middle, 40e-6);
      const same = String(fmu.getFmuState()) === String(end);
      said.push(fmu.terminate());
      return { log, events, said, same, none: refused === undefined, bytes: end.length, version: instance.common.getVersion() };
    },
    [modules.map(([name, code]) => [name, Buffer.from(code).toString("base64")]), token, refs],
  );
  return { ...done, imports };
}
