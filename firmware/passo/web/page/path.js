// The picture of a job: the table with its travel, grid and zeros, the path with what is done, and the tool on it.

import { isLaser } from "./controls.js";
import { View } from "./view.js";
import { _ } from "./words.js";

const NEAR = 14;       // pixels from a path that is meant by a touch
const MOST_SHADES = 24;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// [[moves, share]]: those that lie about there between `low` and `high`, 0 … 1.
function shares(moves, value, low, high) {
  const rows = Array.from({ length: MOST_SHADES + 1 }, () => []);
  for (const move of moves) rows[high > low ? Math.round((value(move) - low) / (high - low) * MOST_SHADES) : 0].push(move);
  return rows.map((row, n) => [row, n / MOST_SHADES]).filter(([row]) => row.length);
}

export class Picture {
  // chosen(place, move): what was touched, in mm, and the move there, or null.
  constructor(canvas, chosen) {
    this.canvas = canvas;
    this.chosen = chosen;
    this.moves = [];
    this.tool = this.aim = this.table = this.marked = null;
    this.apart = Infinity;  // mm between a laser's rows: the area by their length
    this.most = 0;          // power of a laser's job
    this.offsets = [];  // [[name, place of the machine]] of the work offsets that are not chosen
    this.done = 0;
    this.shade = "";
    this.base = document.createElement("canvas");
    this.view = new View(canvas, () => this.draw(), (x, y) => this.touch(x, y));
  }

  show(moves) {
    this.moves = moves;
    this.done = 0;
    this.marked = null;
    this.apart = Infinity;
    this.most = 0;
    if (isLaser() && moves.length) {
      let long = 0;
      for (const { points, rapid, power } of moves) {
        if (rapid) continue;
        this.most = Math.max(this.most, power);
        for (let n = 1; n < points.length; n++) long += Math.hypot(points[n][0] - points[n - 1][0], points[n][1] - points[n - 1][1]);
      }
      const [x, y] = this.bounds().map(([low, high]) => Math.max(high - low, 1));
      this.apart = x * y / (long || 1);
    }
    this.fit();
  }

  // The travel in work coordinates: { box: [[low, high] of x, y, z], zero: the machine's }. True if it is another one.
  setTable(table) {
    const text = JSON.stringify(table);
    if (text === this.known) return false;
    const first = !this.table;
    this.known = text;
    this.table = table;
    if (first && !this.moves.length) this.fit(); else this.draw();
    return true;
  }

  // The box of the job's moves, or null.
  bounds() {
    const box = [0, 1, 2].map(() => [Infinity, -Infinity]);
    for (const move of this.moves) for (const point of move.points) for (let axis = 0; axis < 3; axis++) {
      const value = point[axis] || 0;
      if (value < box[axis][0]) box[axis][0] = value;
      if (value > box[axis][1]) box[axis][1] = value;
    }
    return this.moves.length ? box : null;
  }

  size() {
    const dense = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.round(this.canvas.clientWidth * dense), height = Math.round(this.canvas.clientHeight * dense);
    if (!width || this.canvas.width === width && this.canvas.height === height) return;
    for (const each of [this.canvas, this.base]) Object.assign(each, { width, height });
    this.dense = dense;
    this.fit();
  }

  fit() {
    const box = this.bounds() || this.table && this.table.box || [[-20, 100], [-20, 70], [0, 0]];
    this.view.fit(box.map(([low, high]) => [Math.min(low, 0, high), Math.max(high, 0)]));
  }

  zoom(by) { this.view.zoom(by); }

  stand(solid) { this.view.stand(solid); this.fit(); }

  // The tool is there, and what is before that line is done.
  move(tool, done) {
    const before = this.done;
    this.tool = tool;
    this.done = done;
    if (done < before) this.draw();
    else if (done !== before) this.later((ink) => this.strokes(ink, before, done, true));
    else this.later(null);
  }

  // Show it in the next frame; more(ink): what comes onto the path that is drawn already.
  later(more) {
    if (more && !this.whole) more(this.base.getContext("2d"));
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (!this.canvas.clientWidth) return;
      if (this.whole) this.paint();
      const ink = this.canvas.getContext("2d");
      ink.clearRect(0, 0, this.canvas.width, this.canvas.height);
      ink.drawImage(this.base, 0, 0);
      this.marks(ink);
    });
  }

  draw() {
    this.size();
    this.whole = true;
    this.later(null);
  }

  paint() {
    this.whole = false;
    const ink = this.base.getContext("2d");
    ink.clearRect(0, 0, this.base.width, this.base.height);
    ink.lineJoin = "round";
    this.grid(ink);
    this.zeros(ink);
    if (this.shade) this.shaded(ink);
    else this.strokes(ink, 0, Infinity, false);
    this.strokes(ink, 0, this.done, true);
  }

  line(ink, points, stroke, width, dash = []) {
    ink.beginPath();
    points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...this.view.at(point)));
    ink.setLineDash(dash);
    ink.strokeStyle = stroke;
    ink.lineWidth = width * (this.dense || 1);
    ink.stroke();
    ink.setLineDash([]);
  }

  // Distance of the lines of the grid: some 12 to a view.
  pitch() {
    const wanted = 60 * (this.dense || 1) / this.view.scale, ten = 10 ** Math.floor(Math.log10(wanted));
    return ten * (wanted / ten < 2 ? 2 : wanted / ten < 5 ? 5 : 10);
  }

  extent() {
    if (this.table) return this.table.box;
    const box = this.bounds() || [[-20, 100], [-20, 70], [0, 0]];
    return box.map(([low, high]) => [Math.min(low, 0) - 10, Math.max(high, 0) + 10]);
  }

  grid(ink) {
    const [[x0, x1], [y0, y1]] = this.extent(), step = this.pitch(), thin = colour("--grid"), thick = colour("--grid-more");
    const shade = (n) => (Math.abs(n % 5) < 0.5 ? thick : thin);
    for (let n = Math.ceil(x0 / step); n * step <= x1; n++) this.line(ink, [[n * step, y0], [n * step, y1]], shade(n), 1);
    for (let n = Math.ceil(y0 / step); n * step <= y1; n++) this.line(ink, [[x0, n * step], [x1, n * step]], shade(n), 1);
    if (this.table) this.line(ink, [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]], colour("--edge"), 2);
    this.ruler(ink, step);
  }

  ruler(ink, step) {
    const dense = this.dense || 1, size = step * this.view.scale, text = `${Number(step.toPrecision(3))} mm`, y = this.canvas.height - 10 * dense;
    ink.font = `${13 * dense}px system-ui, sans-serif`;
    const x = this.canvas.width - 10 * dense - size - 6 * dense - ink.measureText(text).width;
    ink.fillStyle = ink.strokeStyle = colour("--text");
    ink.lineWidth = 2 * dense;
    ink.beginPath();
    ink.moveTo(x, y - 5 * dense); ink.lineTo(x, y); ink.lineTo(x + size, y); ink.lineTo(x + size, y - 5 * dense);
    ink.stroke();
    this.word(ink, text, x + size + 6 * dense, y);
  }

  // Text on a ground of its own: it is read on lines, too.
  word(ink, text, x, y) {
    const dense = this.dense || 1, own = ink.fillStyle;
    ink.fillStyle = colour("--sheet");
    ink.fillRect(x - 2 * dense, y - 12 * dense, ink.measureText(text).width + 4 * dense, 15 * dense);
    ink.fillStyle = own;
    ink.fillText(text, x, y);
  }

  // The work's zero with its axes, and the machine's.
  zeros(ink) {
    const long = 40 * (this.dense || 1) / this.view.scale;
    this.line(ink, [[0, 0, 0], [long, 0, 0]], colour("--axis-x"), 3);
    this.line(ink, [[0, 0, 0], [0, long, 0]], colour("--axis-y"), 3);
    if (this.view.solid) this.line(ink, [[0, 0, 0], [0, 0, long]], colour("--key"), 3);
    ink.font = `bold ${13 * (this.dense || 1)}px system-ui, sans-serif`;
    for (const [text, point, name] of [["X", [long * 1.15, 0, 0], "--axis-x"], ["Y", [0, long * 1.15, 0], "--axis-y"]]) {
      ink.fillStyle = colour(name);
      const [x, y] = this.view.at(point);
      this.word(ink, text, x, y);
    }
    const { zero } = this.table || { zero: [0, 0, 0] };
    if (zero.some((value) => Math.abs(value) > 0.01)) this.named(ink, zero, _("machine zero"));
    for (const [name, place] of this.offsets) this.named(ink, place.map((value, axis) => value + zero[axis]), name);
  }

  // A zero that is not the work's of now.
  named(ink, point, name) {
    const [x, y] = this.view.at(point);
    this.cross(ink, point, colour("--offset"));
    ink.fillStyle = colour("--offset");
    this.word(ink, name, x + 8 * (this.dense || 1), y - 6 * (this.dense || 1));
  }

  strokes(ink, from, to, done) {
    const dense = this.dense || 1;
    const apart = this.apart * this.view.scale;
    if (!done && apart > 2 * dense) {  // else the ways back are a block of their own
      this.trace(ink, this.moves.filter((move) => move.rapid));
      Object.assign(ink, { strokeStyle: colour("--grid-more"), lineWidth: dense });
      ink.setLineDash([4 * dense, 4 * dense]);
      ink.stroke();
      ink.setLineDash([]);
    }
    // Rows of a laser are as dark as their power, and as thin as they are close: a fill is the picture that it burns.
    const cuts = this.moves.filter((move) => !move.rapid && move.line >= from && move.line < to);
    const width = Math.min(1.6 * dense, Math.max(0.5 * dense, apart));
    for (const [row, share] of shares(cuts, this.most ? (move) => move.power : () => 0, 0, this.most)) {
      this.trace(ink, row);
      Object.assign(ink, { strokeStyle: colour(done ? "--done" : "--path"), lineWidth: done ? 1.6 * width : width, globalAlpha: this.most ? 0.1 + 0.9 * share : 1 });
      ink.stroke();
    }
    ink.globalAlpha = 1;
  }

  trace(ink, moves) {
    ink.beginPath();
    for (const { points } of moves) points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...this.view.at(point)));
  }

  // The path in colours of its speed, power or depth: blue is the least, red the most.
  shaded(ink) {
    const value = { feed: (move) => move.feed || 0, power: (move) => move.power || 0, depth: (move) => -(move.points[move.points.length - 1][2] || 0) }[this.shade];
    const cuts = this.moves.filter((move) => !move.rapid);
    const low = cuts.reduce((least, move) => Math.min(least, value(move)), Infinity), high = cuts.reduce((most, move) => Math.max(most, value(move)), -Infinity);
    for (const [row, share] of shares(cuts, value, low, high)) {
      this.trace(ink, row);
      Object.assign(ink, { strokeStyle: `hsl(${230 - 230 * share}, 75%, 45%)`, lineWidth: 2 * (this.dense || 1) });
      ink.stroke();
    }
    if (cuts.length) this.legend(ink, low, high);
  }

  // What the colours of shaded() mean.
  legend(ink, low, high) {
    const dense = this.dense || 1, top = 10 * dense, unit = { feed: "mm/min", power: "S", depth: "mm" }[this.shade];
    const least = `${Number(low.toFixed(2))}`, most = `${Number(high.toFixed(2))} ${unit}`;
    ink.font = `${13 * dense}px system-ui, sans-serif`;
    const left = 16 * dense + ink.measureText(least).width;
    ink.fillStyle = colour("--text");
    this.word(ink, least, 10 * dense, top + 11 * dense);
    this.word(ink, most, left + (2 * (MOST_SHADES + 1) + 6) * dense, top + 11 * dense);
    for (let n = 0; n <= MOST_SHADES; n++) {
      ink.fillStyle = `hsl(${230 - 230 * n / MOST_SHADES}, 75%, 45%)`;
      ink.fillRect(left + 2 * n * dense, top, 2 * dense, 12 * dense);
    }
  }

  // The move that is meant, the place to go to, the tool.
  marks(ink) {
    const dense = this.dense || 1;
    if (this.marked) this.line(ink, this.marked.points, colour("--tool"), 5);
    if (this.aim) this.cross(ink, this.aim, colour("--key"));
    if (!this.tool) return;
    const [x, y] = this.view.at(this.tool);
    ink.beginPath();
    ink.moveTo(x, y); ink.lineTo(x - 7 * dense, y - 18 * dense); ink.lineTo(x + 7 * dense, y - 18 * dense);
    ink.closePath();
    Object.assign(ink, { fillStyle: colour("--tool"), strokeStyle: colour("--card"), lineWidth: 1.5 * dense });
    ink.fill();
    ink.stroke();
  }

  cross(ink, point, stroke) {
    const [x, y] = this.view.at(point), arm = 9 * (this.dense || 1);
    ink.beginPath();
    ink.moveTo(x - arm, y); ink.lineTo(x + arm, y); ink.moveTo(x, y - arm); ink.lineTo(x, y + arm);
    Object.assign(ink, { strokeStyle: stroke, lineWidth: 2.5 * (this.dense || 1) });
    ink.stroke();
  }

  // The move nearest to these pixels, or null.
  near(px, py) {
    let best = NEAR * (this.dense || 1), found = null;
    for (const move of this.moves) {
      let [ax, ay] = this.view.at(move.points[0]);
      for (const point of move.points.slice(1)) {
        const [bx, by] = this.view.at(point), x = bx - ax, y = by - ay;
        const part = Math.max(0, Math.min(1, ((px - ax) * x + (py - ay) * y) / (x * x + y * y || 1)));
        const far = Math.hypot(px - ax - part * x, py - ay - part * y);
        if (far < best) [best, found] = [far, move];
        [ax, ay] = [bx, by];
      }
    }
    return found;
  }

  touch(px, py) {
    if (this.pointed) { this.pointed(...this.view.place(px, py)); return; }  // see card_plotter.js
    this.marked = this.near(px, py);
    this.aim = this.view.solid ? null : this.view.place(px, py);
    this.chosen(this.aim, this.marked);
    this.later(null);
  }

  // The move that a line makes.
  mark(line) {
    this.marked = this.moves.filter((move) => move.line === line)[0] || null;
    this.later(null);
  }
}
