// Starts Chromium and opens the page.
import { execFileSync } from "node:child_process";
import { chromium } from "playwright-core";

/** name: of the program, to be found as a shell finds it. WebGL is drawn by the processor, so that pictures do not depend on the machine. */
export function start(name) {
  const executablePath = execFileSync("sh", ["-c", `command -v ${name}`], { encoding: "utf8" }).trim();
  const quiet = ["--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...quiet] });
}

/** Waits until the status line says something that fits. */
export async function says(page, pattern, timeout = 60_000) {
  const fits = ([source]) => new RegExp(source).test(document.getElementById("outcome").textContent);
  await page.waitForFunction(fits, [pattern.source], { timeout });
  // The picture follows when the graphics processor is done.
  await page.waitForFunction(() => document.getElementById("picture").dataset.row === document.getElementById("time").value);
}

/** The picture of the sheet, when it changes no more. */
export async function steady(page) {
  const shot = async () => (await page.locator("#picture").screenshot()).toString("base64");
  let [before, now] = ["", await shot()];
  for (let k = 0; before !== now && k < 20; k++) [before, now] = [now, await shot()];
  return now;
}

/** Goes to a row of the history by the slider, or by the button for one row on. */
export async function goTo(page, row) {
  if (row > Number(await page.getAttribute("#time", "max"))) throw new Error(`there is no row ${row} yet`);
  await page.locator("#time").fill(String(row));
  await says(page, /Stopped|Arrested|Exited|Passed|Ready/);
  await page.waitForFunction((row) => document.getElementById("value-time").textContent.includes(`step ${(64 * row).toLocaleString("en")}`), row);
  await says(page, /./);
}
