// A program of plain G-code as the lines that a controller gets, by the rules of host_tools/programs/program_lines.py: a test compares the two.

const DROPPED = /[\x00-\x17\x19-\x20/\x7f\xa0\u1680\u2000-\u200b\u202f\u205f\u2060\u3000\ufeff]/g;
const MOST_NUMBER = 9999999;

// The text of a file: UTF-8, or Latin-1 as older programs write it.
export function decode(bytes) {
  try {
    return new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(bytes);
  } catch {
    return new TextDecoder("latin1").decode(bytes);
  }
}

// A line without comments, blanks, / and control characters.
export const strip = (line) => line.replace(/\([^)]*\)?|;.*/gs, "").replace(DROPPED, "");

const words = (line) => (line.startsWith("$") ? "" : line.split("=")[0].toUpperCase());
const endsProgram = (line) => (words(line).match(/M\+?[\d.]*/g) || []).some((word) => [2, 30].includes(word.length > 1 ? Number(word.slice(1)) : 0));

function withoutNumber(line) {
  const head = words(line), found = head.match(/N([-+.\d]+)/);
  if (!found || /N.*N/.test(head) || !(Number(found[1]) >= 0 && Number(found[1]) <= MOST_NUMBER)) return line;
  const end = found.index + found[0].length, left = line.slice(0, found.index) + line.slice(end);
  return /^[$%]/.test(left) || (line[end] && !/[a-z]/i.test(line[end])) ? line : left;
}

// {lines: [[number, text]], wrong: {line, letter} or null, last, behind}: `wrong`: a letter that is none of G-code, lines end there; `behind`: how many
// lines say something behind the program's last one, `last`.
export function programLines(text) {
  const rows = text.split(/\r\n|\r|\n/), lines = [];
  let begun = false, last = 0;
  for (let at = 0; at < rows.length && !last; at++) {
    const line = strip(rows[at]);
    const letter = line.match(/[^!-~]|[?!~]/u);
    if (letter) return { lines, wrong: { line: at + 1, letter: letter[0] }, last: 0, behind: 0 };
    if (line === "%" && begun) last = at + 1;
    if (!line || line === "%" || /^[Oo:]\d+$/.test(line)) continue;
    begun = true;
    if (endsProgram(line)) last = at + 1;
    const kept = withoutNumber(line);
    if (kept) lines.push([at + 1, kept]);
  }
  const behind = last ? rows.slice(last).filter((row) => /[^ \t%\x1a]/.test(row)).length : 0;
  return { lines, wrong: null, last, behind };
}

// The first of the lines that no job may have, [number, text], or undefined: a $ line but $H.
export const jobError = (lines) => lines.find(([, line]) => line.split("=")[0].includes("$") && line.replace(/\//g, "").toUpperCase() !== "$H");
