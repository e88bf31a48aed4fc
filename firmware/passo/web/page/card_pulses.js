// Pulse files: the codes with the one under way, the path that they make, and how they are played.

import { grey } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const NEAR_MM = 0.2;  // between two places of the picture
const AROUND = 240;   // characters of the list before and behind the code under way
const CODES = ["x+", "x-", "y+", "y-", "z+", "z-", "x+y+", "x+y-", "x-y+", "x-y-", "x+z+", "x+z-", "x-z+", "x-z-", "y+z+", "y+z-", "y-z+", "y-z-",
  "x+y+z+", "x+y+z-", "x+y-z+", "x+y-z-", "x-y+z+", "x-y+z-", "x-y-z+", "x-y-z-"];
const BITS = ["Tool", "Direction X", "Pulse X", "Direction Y", "Pulse Y", "Direction Z", "Pulse Z", "Drives"];  // from bit 0 on
const HOW = { load: "Sending", run: "Playing", done: "Done", start: "Back at the start of the file", oldest: "Back as far as the board remembers",
  failed: "Ended" };

const step = (code, axis) => { const at = CODES[code].indexOf(axis); return at < 0 ? 0 : CODES[code][at + 1] === "+" ? 1 : -1; };
const STEPS = CODES.map((name, code) => [step(code, "x"), step(code, "y")]);

export class PulseFile {
  constructor(page, message) {
    this.page = page;
    this.scale = message.scale || [1, 1, 1];
    this.text = "";
    this.starts = new Uint32Array(0);  // of each command, its character
    this.origin = [0, 0];
    this.end = null;
    this.marked = -1;
    $("pace").max = message.fastest || "";
    $("pace-most").textContent = message.fastest ? `1 … ${message.fastest} mm/min` : "";
    $("pace-form").onsubmit = (event) => { event.preventDefault(); page.order("pace", { speed: Number($("pace").value) }); };
    this.showPort(0, message.bits || "76543210");
  }

  // Moves of the picture, in mm from where the file begins.
  read(text) {
    this.text = text;
    const starts = [];
    const moves = [];
    let x = 0, y = 0, on = false, points = [[0, 0]], last = [0, 0];
    const [sx, sy] = [this.scale[0], this.scale[1] || 1];
    this.places = [];  // [command, x, y] now and then
    const close = (line) => {
      if (points.length > 1) moves.push({ line, points, rapid: !on, off: !on });
      points = [points[points.length - 1]];
    };
    for (let at = 0; at < text.length; at++) {
      const code = text.charCodeAt(at) - 65;
      if (code >= 0 && code < 26) {
        if (starts.length % 1024 === 0) this.places.push([starts.length, x, y]);
        starts.push(at);
        const [dx, dy] = STEPS[code];
        x += dx; y += dy;
        const place = [x / sx, y / sy];
        const turned = text[at] !== text[at + 1];
        if (Math.abs(place[0] - last[0]) + Math.abs(place[1] - last[1]) >= NEAR_MM * 40 || turned && Math.hypot(place[0] - last[0], place[1] - last[1]) >= NEAR_MM) {
          points.push(place);
          last = place;
          if (points.length > 20) close(starts.length);
        }
      } else if ("[]()$@*+".includes(text[at])) {
        if (starts.length % 1024 === 0) this.places.push([starts.length, x, y]);
        starts.push(at);
        if (text[at] === "(" || text[at] === ")") {
          points.push([x / sx, y / sy]);
          close(starts.length);
          on = text[at] === "(";
        }
      }
    }
    points.push([x / sx, y / sy]);
    close(starts.length);
    if (moves.every((move) => move.off)) for (const move of moves) move.rapid = false;  // a file that never switches the tool
    this.moves = moves;
    this.starts = Uint32Array.from(starts);
    this.marked = -1;
    this.end = null;
    return this.moved();
  }

  moved() {
    const [x, y] = this.origin;
    return (this.moves || []).map((move) => ({ ...move, points: move.points.map((point) => [point[0] + x, point[1] + y]) }));
  }

  // Steps from the start of the file to before command `number`.
  placeAt(number) {
    const from = this.places ? this.places[Math.min(this.places.length - 1, Math.floor(number / 1024))] : null;
    if (!from) return [0, 0];
    let [at, x, y] = from;
    for (; at < number && at < this.starts.length; at++) {
      const code = this.text.charCodeAt(this.starts[at]) - 65;
      if (code >= 0 && code < 26) { x += STEPS[code][0]; y += STEPS[code][1]; }
    }
    return [x / this.scale[0], y / (this.scale[1] || 1)];
  }

  // Where the file begins: told by where the machine is in it, or it begins here.
  place(report) {
    const now = report.job;
    const here = report.w || [];
    if (!this.moves || here.length < 2) return;
    let origin = this.origin;
    if (now && now.how === "run") {
      if (!report.manual) {
        const [x, y] = this.placeAt(now.done);
        origin = [here[0] - x, here[1] - y];
      }
      this.end = here;
    } else if (!this.end || Math.hypot(here[0] - this.end[0], here[1] - this.end[1]) > 0.05) {
      origin = [here[0], here[1]];
      this.end = null;
    }
    if (Math.hypot(origin[0] - this.origin[0], origin[1] - this.origin[1]) > 0.3) {
      this.origin = origin;
      this.page.picture.show(this.moved());
    }
  }

  told(now) {
    let text = `${now.name}: ${_(now.checked && now.how === "done" ? "Checked: no error" : now.checked && now.how === "load" ? "Checking" : HOW[now.how] || "")}`;
    if (now.how !== "load" && now.lines) text += `, ${_("{done} of {lines} codes, {left} left", { done: now.done, lines: now.lines, left: now.lines - now.done })}`;
    if (now.how === "run" && now.back) text += `, ${_("backward")}`;
    if (now.passes > 1) text += `, ${_("pass {pass} of {passes}", { pass: now.pass, passes: now.passes })}`;
    if (now.row) text += `, ${_("line {row} column {column}", { row: now.row, column: now.column })}`;
    return text;
  }

  mark(now) {
    const number = now ? now.done : 0;
    if (now && now.how === "load" || number === this.marked) return true;
    this.marked = number;
    const { text, starts } = this;
    const at = number < starts.length ? starts[number] : text.length;
    const next = number + 1 < starts.length ? starts[number + 1] : text.length;
    const code = document.createElement("b");
    code.className = "code";
    code.textContent = text.slice(at, next).trim();
    const first = Math.max(0, at - AROUND);
    $("lines").replaceChildren(`${first ? "…" : ""}${text.slice(first, at)}`, code, text.slice(next, next + AROUND));
    $("lines").scrollTop = code.offsetTop - $("lines").offsetTop - $("lines").clientHeight / 2;
    return true;
  }

  show(report, why) {
    this.place(report);
    const now = report.job;
    const busy = Boolean(now) && ["load", "run"].includes(now.how);
    const mine = report.link && report.owner !== "guest";
    const stands = ["Idle", "Hold"].includes(report.state);
    const by_hand = Boolean(report.manual) && report.state === "Hold" && busy;
    for (const name of ["back", "step_back"]) {
      const plays = mine && now && now.how !== "load" && !now.checked;
      grey(document.querySelector(`[data-play=${name}]`), by_hand ? _("There were moves by hand in the pause.") : plays ? "" : why.mine || why.rest || _("No job is under way."));
    }
    $("by-hand").hidden = !by_hand;
    if (by_hand) for (const id of ["resume", "single"]) grey($(id), _("There were moves by hand in the pause."));
    $("asked").hidden = !report.asked;
    const wait = report.wait ? _("waits {seconds} s", { seconds: report.wait.toFixed(1) }) : "";
    if ($("countdown").textContent !== wait) $("countdown").textContent = wait;
    grey($("teach-begin"), why.mine || (mine && stands ? "" : why.rest || _("The machine is not at rest.")));
    this.showPort(report.port || 0);
  }

  // The image of the parallel port; `bits`: the place of bits 7 to 0 in it, - where one is switched off.
  showPort(value, bits) {
    if (bits) {
      this.names = [];
      [...bits].forEach((place, n) => { if (place !== "-") this.names[Number(place)] = BITS[7 - n]; });
      this.port = "";
    }
    const shown = `${value} ${document.documentElement.lang}`;
    if (this.port === shown) return;
    this.port = shown;
    $("port").replaceChildren(...[7, 6, 5, 4, 3, 2, 1, 0].filter((bit) => this.names[bit]).map((bit) => {
      const item = document.createElement("li");
      const on = Boolean(value >> bit & 1);
      item.textContent = `${_(this.names[bit])}: ${on ? 1 : 0}`;
      item.className = on ? "on" : "";
      return item;
    }));
  }
}
