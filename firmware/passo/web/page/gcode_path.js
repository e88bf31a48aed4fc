// The path of a job of G-code, for a picture.

import { programLines } from "./program.js";

const ARC_STEPS = 48;

// [{line, points: [[x, y, z]], rapid, feed, power}] of G-code; work coordinates in mm, mm/min. A picture: the board alone decides what moves.
export function read(text) {
  const moves = [];
  let feed = 0, power = 0, lit = false;
  let place = [0, 0, 0], absolute = true, unit = 1, motion = 0, plane = 17;
  programLines(text).lines.forEach(([number, bare]) => {
    const line = bare.toUpperCase();
    const words = {};
    const codes = [];
    for (const word of line.match(/[A-Z]\s*[-+]?[\d.]+/g) || []) {
      const letter = word[0], value = word.slice(1);
      if (letter === "G") codes.push(Number(value)); else words[letter] = Number(value);
      if (letter === "M" && Number(value) >= 3 && Number(value) <= 5) lit = Number(value) < 5;
    }
    let other = false;
    for (const code of codes) {
      if (code <= 3) motion = code;
      else if (code === 20) unit = 25.4;
      else if (code === 21) unit = 1;
      else if (code === 90) absolute = true;
      else if (code === 91) absolute = false;
      else if (code >= 17 && code <= 19) plane = code;
      else if ([4, 10, 28, 30, 53, 92].includes(code)) other = true;
    }
    if ("F" in words) feed = words.F * unit;
    if ("S" in words) power = words.S;
    if (other || !("X" in words || "Y" in words || "Z" in words)) return;
    const to = place.map((now, axis) => {
      const word = words["XYZ"[axis]];
      return word === undefined ? now : (absolute ? 0 : now) + word * unit;
    });
    const arc = motion >= 2 && plane === 17 && ("I" in words || "J" in words || "R" in words);
    moves.push({ line: number, points: arc ? bend(place, to, words, unit, motion === 2) : [place, to], rapid: motion === 0, feed, power: lit ? power : 0 });
    place = to;
  });
  return moves;
}

function bend(from, to, words, unit, clockwise) {
  let i = (words.I || 0) * unit, j = (words.J || 0) * unit;
  if ("R" in words) {
    const r = words.R * unit, x = to[0] - from[0], y = to[1] - from[1], d = Math.hypot(x, y) || 1e-9;
    let h = -Math.sqrt(Math.max(0, 4 * r * r - d * d)) / d;
    if (!clockwise) h = -h;
    if (r < 0) h = -h;
    i = 0.5 * (x - y * h);
    j = 0.5 * (y + x * h);
  }
  const cx = from[0] + i, cy = from[1] + j, r = Math.hypot(i, j);
  const start = Math.atan2(-j, -i);
  const turn = (Math.atan2(to[1] - cy, to[0] - cx) - start) * (clockwise ? -1 : 1);
  const ahead = ((turn % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI);
  const sweep = (ahead <= 5e-7 ? 2 * Math.PI : ahead) * (clockwise ? -1 : 1);  // an end that is so near closes the circle
  const points = [];
  for (let n = 0; n <= ARC_STEPS; n++) {
    const angle = start + (sweep * n) / ARC_STEPS;
    points.push([cx + r * Math.cos(angle), cy + r * Math.sin(angle), from[2] + ((to[2] - from[2]) * n) / ARC_STEPS]);
  }
  return points;
}
