// Starts digests.c as WebAssembly: node wasm.mjs digests.wasm
import { readFileSync } from "node:fs";

const bytes = readFileSync(process.argv[2]);
let memory;
const write_text = (at) => {
  const text = new Uint8Array(memory.buffer, at);
  process.stdout.write(Buffer.from(text.subarray(0, text.indexOf(0))).toString("latin1"));
};
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(bytes), { env: { write_text } });
memory = exports.memory;
process.exitCode = exports.print_digests();
