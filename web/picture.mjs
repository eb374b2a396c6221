// The page's picture for the README: node picture.mjs BROWSER FOLDER PICTURE.png
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { goTo, says, start } from "./browser.mjs";

const [program, folder, picture] = process.argv.slice(2);
const browser = await start(program);
const page = await browser.newPage({ viewport: { width: 1180, height: 760 }, colorScheme: "light" });
await page.goto(pathToFileURL(join(folder, "index.html")).href);
await says(page, /Ready/);
await page.selectOption("#pace", "0");
await page.click("#run");
await says(page, /Exited/);
// The first segments have just failed.
await goTo(page, 62);
await page.screenshot({ path: picture });
await browser.close();
console.log(`written: ${picture}`);
