// Makes the page: one file with everything inside.
// node build.mjs KERNEL.wasm FABRIC FOLDER
import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { gzipAsync } from "@gfx/zopfli";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [kernel, program, out] = process.argv.slice(2);
const here = dirname(fileURLToPath(import.meta.url));
const top = dirname(here);
const read = (...path) => readFileSync(join(...path), "utf8");
const written = (name, text) => {
  const path = join(out, name);
  mkdirSync(dirname(path), { recursive: true });
  writeFileSync(path, text);
  return path;
};
const pairs = (text, pattern) => [...text.matchAll(pattern)].map((match) => match.slice(1));

/** Places of the C structures, constants, pinned digests: from what other commands generate and check. */
const layout = read(top, "tests/c/abi/layout.inc") + read(top, "tests/c/abi/scene.inc").replace(/^(REAL|WHOLE)\(/gm, "$1(fk_scene, ");
const structures = Object.fromEntries(pairs(layout, /^SIZE\((\w+), (\d+)\)/gm).map(([name, size]) => [name, { size: Number(size), fields: {} }]));
for (const [name, field, offset, size] of pairs(layout, /^(?:FIELD|REAL|WHOLE)\((\w+), ([\w.]+), (\d+), (\d+)\)/gm)) structures[name].fields[field] = [Number(offset), Number(size)];
const data = {
  structures,
  wholes: pairs(layout, /^WHOLE\(fk_scene, ([\w.]+)/gm).flat(),
  constants: Object.fromEntries(pairs(read(top, "include/fabric_kernel.h"), /^#define (FK_\w+) (-?\d+)$/gm).map(([name, value]) => [name, Number(value)])),
  pinned: Object.fromEntries(pairs(read(top, "tests/golden/pins"), /^scene (\w+) ([0-9a-f]{16})$/gm)),
  preset: {},
  fabrics: {},
  fragments: {},
  native: {},
};

/** The parameters of a scene file, as `fabric scene` prints them. */
function parameters(file) {
  const printed = execFileSync(program, ["scene", file], { encoding: "utf8" });
  let table = "";
  const found = {};
  for (const line of printed.split("\n")) {
    const group = line.match(/^\[(.+)\]$/);
    const value = line.match(/^"?([\w.]+)"? = (.+)$/);
    // What the scene does not read stands in a table of its own, by its whole name.
    if (group) table = group[1] === "unread" ? "" : `${group[1]}.`;
    // A fabric's own table: the numbers that it gives stand below it.
    else if (value && !/^(back_)?fabric\./.test(table)) found[table + value[1]] = value[2];
  }
  return found;
}
const PRESET = 'preset = "sheet_3in_sphere"\n';
const plain = parameters(written("scenes/preset.toml", PRESET));
const number = (text) => (text === "true" ? 1 : text === "false" ? 0 : Number(text));
const numbers = (text) => text.replace(/[[\]]/g, "").split(",").map((part) => number(part.trim()));
data.preset = Object.fromEntries(Object.entries(plain).map(([key, text]) => [key, numbers(text)]).filter(([, found]) => !found.some(Number.isNaN)));
const [[fabrics]] = pairs(read(here, "index.html"), /<select id="fabric"([^]*?)<\/select>/g);
/** What a scene file changes in the preset. */
function changes(name, text) {
  const changed = Object.entries(parameters(written(`scenes/${name}.toml`, PRESET + text))).filter(([key, text]) => plain[key] !== text && key !== "projectile.shape");
  const found = Object.fromEntries(changed.map(([key, text]) => [key, numbers(text)]));
  if (Object.values(found).flat().some(Number.isNaN)) throw new Error(`${name}: not a number`);
  return found;
}
for (const [name] of pairs(fabrics, /value="(\w+)"/g)) data.fabrics[name] = changes(`fabric-${name}`, `[fabric]\nname = "${name}"\n`);
const [[calibres]] = pairs(read(here, "index.html"), /<select id="calibre"([^]*?)<\/select>/g);
for (const [name] of pairs(calibres, /value="(.+?)"/g)) data.fragments[name] = changes("fragment", `[projectile]\nshape = "fsp"\ncalibre = "${name}"\n`);

const bundled = async (entry, format, modules) => {
  const plugin = {
    name: "built",
    setup(builder) {
      builder.onResolve({ filter: /^built:/ }, ({ path }) => ({ path, namespace: "built" }));
      builder.onLoad({ filter: /.*/, namespace: "built" }, ({ path }) => modules[path]);
    },
  };
  const options = { bundle: true, write: false, minify: true, target: "es2022", legalComments: "eof", plugins: [plugin] };
  const { outputFiles } = await build({ ...options, entryPoints: [join(here, "src", entry)], format, charset: "utf8" });
  return outputFiles[0].text;
};
const json = () => ({ "built:data": { contents: Object.entries(data).map(([key, value]) => `export const ${key} = ${JSON.stringify(value)};`).join("\n") } });

/** The native library's digest of each named scene. */
const scene = await import(pathToFileURL(written("scene.mjs", await bundled("scene.ts", "esm", json()))));
mkdirSync(join(out, "native"), { recursive: true });
for (const { name, changes } of scene.NAMED) {
  const file = written(`scenes/${name}.toml`, scene.toToml({ ...scene.DEFAULTS, ...changes }));
  execFileSync(program, ["run", "--no-report", file, "--out", join(out, "native", name)], { stdio: ["ignore", "ignore", "inherit"] });
  const { digest, ended_by: endedBy, steps } = JSON.parse(read(out, "native", name, "summary.json"));
  data.native[name] = { digest, endedBy, steps };
  console.log(`${name}: ${endedBy} after ${steps} steps, ${digest}`);
}

const worker = await bundled("worker.ts", "iife", json());
const page = await bundled("main.ts", "esm", {
  ...json(),
  "built:kernel": { contents: Buffer.from(await gzipAsync(readFileSync(kernel), { numiterations: 5 })).toString("base64"), loader: "text" },
  "built:worker": { contents: worker, loader: "text" },
});
const html = read(here, "index.html")
  .replace("/* style.css */", () => read(here, "style.css").replace(/\s+/g, " "))
  .replace("/* page.js */", () => page.replaceAll("</script", "<\\/script"));
written("index.html", html);
console.log(`${join(out, "index.html")}: ${Math.round(Buffer.byteLength(html) / 1000)} kB, with gzip ${Math.round(gzipSync(html).length / 1000)} kB; kernel ${Math.round(readFileSync(kernel).length / 1000)} kB`);
