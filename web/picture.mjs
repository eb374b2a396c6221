// The page's picture for the README: node picture.mjs BROWSER FOLDER PICTURE.png
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { says, start } from "./browser.mjs";

const [program, folder, picture] = process.argv.slice(2);
const browser = await start(program);
const page = await browser.newPage({ viewport: { width: 1180, height: 760 }, colorScheme: "light" });
await page.goto(pathToFileURL(join(folder, "index.html")).href);
// It goes to the frame at which the sheet is deepest: the first segments have just failed.
await page.waitForSelector("#card:visible");
await page.waitForFunction(() => Number(document.getElementById("picture").dataset.row) < Number(document.getElementById("time").max));
await says(page, /Exited/);
await page.screenshot({ path: picture });
await browser.close();
console.log(`written: ${picture}`);
