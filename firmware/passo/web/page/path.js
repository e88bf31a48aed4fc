// The path of a job seen from above, how much of it is done, and the tool.

const ARC_STEPS = 48;

// [{line, points: [x, y], rapid}] of G-code; work coordinates in mm. A picture: the board alone decides what moves.
export function read(text) {
  const moves = [];
  let place = [0, 0, 0], absolute = true, unit = 1, motion = 0, plane = 17;
  text.split("\n").forEach((raw, index) => {
    const line = raw.replace(/\(.*?\)|;.*/g, "").toUpperCase();
    const words = {};
    const codes = [];
    for (const [, letter, value] of line.matchAll(/([A-Z])\s*([-+]?[\d.]+)/g)) {
      if (letter === "G") codes.push(Number(value)); else words[letter] = Number(value);
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
    if (other || !("X" in words || "Y" in words || "Z" in words)) return;
    const to = place.map((now, axis) => {
      const word = words["XYZ"[axis]];
      return word === undefined ? now : (absolute ? 0 : now) + word * unit;
    });
    const arc = motion >= 2 && plane === 17 && ("I" in words || "J" in words || "R" in words);
    moves.push({ line: index + 1, points: arc ? bend(place, to, words, unit, motion === 2) : [place, to], rapid: motion === 0 });
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
    points.push([cx + r * Math.cos(angle), cy + r * Math.sin(angle)]);
  }
  return points;
}

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.moves = [];
    this.tool = null;
    this.aim = null;
    this.done = 0;
  }

  show(moves) { this.moves = moves; this.done = 0; this.fit(); this.draw(); }

  fit() {
    const all = this.moves.flatMap((move) => move.points).concat(this.tool ? [this.tool] : [], this.aim ? [this.aim] : [], [[0, 0]]);
    const xs = all.map((point) => point[0]), ys = all.map((point) => point[1]);
    const low = (values) => values.reduce((a, b) => Math.min(a, b), Infinity), high = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [x0, x1, y0, y1] = [low(xs), high(xs), low(ys), high(ys)];
    const room = Math.max(x1 - x0, y1 - y0, 100) * 0.08;
    const { width, height } = this.canvas;
    this.scale = Math.min(width / (Math.max(x1 - x0, 100) + 2 * room), height / (Math.max(y1 - y0, 70) + 2 * room));
    this.x0 = (x0 + x1) / 2 - width / 2 / this.scale;
    this.y1 = (y0 + y1) / 2 + height / 2 / this.scale;
  }

  at([x, y]) { return [(x - this.x0) * this.scale, (this.y1 - y) * this.scale]; }

  // Work coordinates of a touch.
  place(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * this.canvas.width, y = ((event.clientY - box.top) / box.height) * this.canvas.height;
    return [x / this.scale + this.x0, this.y1 - y / this.scale];
  }

  move(tool, doneLine) {
    this.tool = tool;
    this.done = doneLine;
    const [x, y] = this.scale ? this.at(tool) : [-1, -1];
    if (x < 0 || y < 0 || x > this.canvas.width || y > this.canvas.height) this.fit();
    this.draw();
  }

  draw() {
    if (!this.scale) this.fit();
    const ink = this.canvas.getContext("2d");
    const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
    ink.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const [zx, zy] = this.at([0, 0]);
    this.stroke(ink, colour("--line"), [[zx, 0], [zx, this.canvas.height]], 1);
    this.stroke(ink, colour("--line"), [[0, zy], [this.canvas.width, zy]], 1);
    for (const done of [false, true]) {
      ink.beginPath();
      for (const move of this.moves) {
        if (move.line < this.done !== done || move.rapid) continue;
        move.points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...this.at(point)));
      }
      ink.strokeStyle = colour(done ? "--done" : "--path");
      ink.lineWidth = done ? 2.5 : 1.5;
      ink.stroke();
    }
    if (this.aim) this.cross(ink, this.at(this.aim), colour("--key"));
    if (this.tool) {
      ink.beginPath();
      ink.arc(...this.at(this.tool), 7, 0, 7);
      ink.fillStyle = colour("--tool");
      ink.fill();
    }
  }

  stroke(ink, colour, points, width) {
    ink.beginPath();
    points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...point));
    ink.strokeStyle = colour;
    ink.lineWidth = width;
    ink.stroke();
  }

  cross(ink, [x, y], colour) {
    this.stroke(ink, colour, [[x - 10, y], [x + 10, y]], 2);
    this.stroke(ink, colour, [[x, y - 10], [x, y + 10]], 2);
  }
}
