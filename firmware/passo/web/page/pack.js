// A file as the board stores it: the bytes that a PC would send, their CRC-32, and deflated (RFC 1951) with the window that a board has.

import { decode, jobError, programLines } from "./program.js";

const TAG = 8, MOST_TAG = 9999999;  // characters of a number, and the highest
const WINDOW = 1000, LONGEST = 258, TRIES = 32;

// A name without its accents, which neither a board nor a PC's jobs take.
export const unaccented = (name) => name.normalize("NFD").replace(/[\u0300-\u036f]/g, "");

// The bytes of a job, or null if the file is none of the language; of G-code with a line that no job may have {line, letter} or {line, text}.
export function jobBytes(language, bytes) {
  const text = new TextDecoder("latin1").decode(bytes);
  if (language === "plotter") return packets(text);
  if (text.includes("\0")) return null;  // a picture, or another file that is no text
  if (language === "grbl") return numbered(decode(bytes));
  const kept = text.replace(/\s/g, "");
  return kept ? Uint8Array.from(kept, (letter) => letter.charCodeAt(0)) : null;
}

// A line for each line of the file, with its number as N word.
function numbered(text) {
  const { lines, wrong } = programLines(text), refused = jobError(lines), rows = [];
  if (wrong) return wrong;
  if (refused) return { line: refused[0], text: refused[1] };
  if (!lines.length) return null;
  for (const [number, line] of lines) {
    const longest = line.includes("=") ? 243 : line.includes(":") ? 127 : 80;
    rows[number - 1] = !/^[a-z]/i.test(line) || line.length > longest - TAG || number > MOST_TAG ? line : `N${number}${line}`;
  }
  return new TextEncoder().encode(Array.from(rows, (row) => row || "").join("\n") + "\n");
}

// Words of passo send, a packet a line; or packets as they are.
function packets(text) {
  const codes = { LINE: "l", MOVE: "m", END: "e", SPEED: "s" };
  const made = [];
  const good = text.length % 6 === 0 && text.length && [...text].every((letter, at) => at % 6 < 5 ||
    ([...text.slice(at - 5, at)].reduce((sum, each) => sum + each.charCodeAt(0), 0) - letter.charCodeAt(0)) % 256 === 0);
  if (good) return Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  for (const row of text.split("\n")) {
    const [word, x = "0", y = "0"] = row.split("#")[0].trim().toUpperCase().split(/\s+/);
    if (!word) continue;
    if (!(word in codes) || ![x, y].every((each) => /^\d{1,5}$/.test(each) && Number(each) < 65536)) return null;
    const packet = [codes[word].charCodeAt(0), x >> 8, x & 255, y >> 8, y & 255];
    made.push(...packet, packet.reduce((sum, each) => sum + each, 0) & 255);
  }
  return made.length ? Uint8Array.from(made) : null;
}

export function crc32(bytes) {
  let sum = 0xFFFFFFFF;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit++) sum = (sum >>> 1) ^ (sum & 1 ? 0xEDB88320 : 0);
  }
  return (sum ^ 0xFFFFFFFF) >>> 0;
}

// One block of the fixed codes (3.2.6): literals, and copies of what lies at most WINDOW bytes before: a board has 1024.
export function deflate(bytes) {
  const out = [];
  let held = 0, count = 0;
  const put = (value, bits) => {
    held |= value << count;
    for (count += bits; count >= 8; count -= 8, held >>>= 8) out.push(held & 255);
  };
  const code = (value, bits) => {  // a Huffman code goes its highest bit first
    for (let bit = bits - 1; bit >= 0; bit--) put((value >> bit) & 1, 1);
  };
  const symbol = (value) => {
    if (value < 144) code(0x30 + value, 8);
    else if (value < 256) code(0x190 + value - 144, 9);
    else if (value < 280) code(value - 256, 7);
    else code(0xC0 + value - 280, 8);
  };
  // Symbol, extra bits and their value of a length or distance that counts from 0; `step` symbols have the same number of extra bits.
  const split = (value, step) => {
    let extra = 0, first = 0, number = 0;
    for (let width = 1; ; number++) {
      extra = Math.max(0, Math.floor(number / step) - 1);
      width = 1 << extra;
      if (value < first + width) return [number, extra, value - first];
      first += width;
    }
  };
  const length = (size) => {
    const [number, extra, rest] = size === LONGEST ? [28, 0, 0] : split(size - 3, 4);
    symbol(257 + number);
    put(rest, extra);
  };
  const distance = (back) => {
    const [number, extra, rest] = split(back - 1, 2);
    code(number, 5);
    put(rest, extra);
  };
  const heads = new Map(), before = new Int32Array(bytes.length);
  const key = (at) => bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16;
  const note = (at) => {
    if (at + 2 >= bytes.length) return;
    before[at] = heads.has(key(at)) ? heads.get(key(at)) : -1;
    heads.set(key(at), at);
  };
  put(3, 3);  // the last block, of fixed codes
  for (let at = 0; at < bytes.length;) {
    let best = 0, from = 0;
    let other = at + 2 < bytes.length && heads.has(key(at)) ? heads.get(key(at)) : -1;
    for (let tries = 0; other >= 0 && at - other <= WINDOW && tries < TRIES; tries++, other = before[other]) {
      let size = 0;
      while (size < LONGEST && at + size < bytes.length && bytes[other + size] === bytes[at + size]) size++;
      if (size > best) [best, from] = [size, other];
    }
    if (best < 3) {
      symbol(bytes[at]);
      note(at++);
      continue;
    }
    length(best);
    distance(at - from);
    for (const end = at + best; at < end; at++) note(at);
  }
  symbol(256);
  if (count) out.push(held & 255);
  return Uint8Array.from(out);
}
