// Digests in a third interpreter, MicroPython as WebAssembly: in a worker of a browser, or in node with its input at stdin.
//
// In: {texts: {path: text}, files: {path: [bytes]}, jobs: [[arguments of digest.py]]}. Out: {lines, ms}: what digest.py printed for
// each job, and how long it took.

import { load, write } from "./firmware.js";

async function digests({ texts, files, jobs }) {
  const said = [];
  const python = await load(texts, (line) => said.push(line));
  write(python, Object.fromEntries(Object.entries(files).map(([path, bytes]) => [path, new Uint8Array(bytes)])));
  python.runPython("import digest");
  const ms = [];
  for (const job of jobs) {
    python.globals.set("arguments", JSON.stringify(job));
    const begun = performance.now();
    python.runPython("import json\ndigest.main(json.loads(arguments))");
    ms.push(performance.now() - begun);
  }
  return { lines: said, ms };
}

if (typeof WorkerGlobalScope !== "undefined") {
  onmessage = async ({ data }) => postMessage(await digests(data));
} else {
  const { readFileSync } = await import("node:fs");
  console.log(JSON.stringify(await digests(JSON.parse(readFileSync(0)))));
  process.exit(0);
}
