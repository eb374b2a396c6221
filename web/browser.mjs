// Starts Chromium and opens the page.
import { execFileSync } from "node:child_process";
import { chromium } from "playwright-core";

/** name: of the program, to be found as a shell finds it. WebGL is drawn by the processor, so that pictures do not depend on the machine. */
export function start(name) {
  const executablePath = execFileSync("sh", ["-c", `command -v ${name}`], { encoding: "utf8" }).trim();
  const quiet = ["--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...quiet] });
}

/** Waits until the status line says something that fits, and the picture shows it. */
export async function says(page, pattern) {
  const fits = ([source]) => new RegExp(source).test(document.getElementById("outcome").textContent);
  await page.waitForFunction(fits, [pattern.source], { timeout: 60_000 });
  // The picture follows when the graphics processor is done.
  await page.waitForFunction(() => document.getElementById("picture").dataset.row === document.getElementById("time").value);
}

/** The picture of the sheet, drawn anew. */
export function drawn(page) {
  return page.evaluate(() => {
    document.getElementById("colouring").dispatchEvent(new Event("change"));
    // A canvas of WebGL can be read until the browser shows it.
    return new Promise((done) => requestAnimationFrame(() => done(document.getElementById("picture").toDataURL())));
  });
}

/** Goes to a row of the history by the slider, or by the button for one row on. */
export async function goTo(page, row) {
  if (row > Number(await page.getAttribute("#time", "max"))) throw new Error(`there is no row ${row} yet`);
  await page.locator("#time").fill(String(row));
  await says(page, /Stopped|Arrested|Exited|Passed|Ready/);
  await page.waitForFunction((row) => document.getElementById("value-time").textContent.includes(`step ${(64 * row).toLocaleString("en")}`), row);
  await says(page, /./);
}
