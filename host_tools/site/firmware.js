// MicroPython with the firmware in its file system, for a worker of a browser and for node.
//
//   const python = await load(new URL(".", import.meta.url), console.log);
//   python.runPython("import passo.app");

import { loadMicroPython } from "./micropython.mjs";

const HEAP_BYTES = 24 * 1024 * 1024;
const STACK_WORDS = 16 * 1024;
const FOLDER = "/lib";

// Texts to files: {"passo/app.py": "…"}.
export function write(python, texts) {
  const made = new Set();
  for (const [name, text] of Object.entries(texts)) {
    const parts = `${FOLDER}/${name}`.split("/");
    for (let n = 2; n < parts.length; n++) {
      const folder = parts.slice(0, n).join("/");
      if (!made.has(folder) && !python.FS.analyzePath(folder).exists) python.FS.mkdir(folder);
      made.add(folder);
    }
    python.FS.writeFile(parts.join("/"), text);
  }
}

// `texts`: what firmware.json holds; `said(line)`: what Python prints.
export async function load(texts, said) {
  const python = await loadMicroPython({ heapsize: HEAP_BYTES, pystack: STACK_WORDS, stdout: said, stderr: said });
  write(python, texts);
  python.runPython(`import sys\nif "${FOLDER}" not in sys.path: sys.path.append("${FOLDER}")`);
  return python;
}
