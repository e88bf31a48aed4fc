// The plotter: a job in the words of its packets, how much of it is drawn, the pen, and the speed.

import { grey } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);

export class Plotter {
  constructor(page, message) {
    this.page = page;
    this.scale = message.scale || [10, 10];
    const speed = message.speed || { unit: "", default: 1000, min: 1, max: 65535 };
    const field = $("draw-speed");
    [field.min, field.max, field.value] = [speed.min, speed.max, speed.default];
    this.speed = speed;
    this.times = [];
    $("points-form").onsubmit = (event) => { event.preventDefault(); this.make(); };
    $("points-next").onclick = () => { $("points").value = `${$("points").value.trim()}\n`; };
    $("points-click").onclick = () => this.click($("points-click").getAttribute("aria-pressed") !== "true");
    this.click(false);
    $("draw-speed-form").onsubmit = (event) => { event.preventDefault(); page.order("pace", { speed: Number(field.value) }); };
  }

  // A tap on the picture is a point of the last object, while that is wanted.
  click(on) {
    $("points-click").setAttribute("aria-pressed", on);
    this.page.picture.pointed = on ? (x, y) => {
      const before = $("points").value;
      $("points").value = `${before}${!before || before.endsWith("\n") ? "" : " "}${x.toFixed(1)},${y.toFixed(1)}`;
    } : null;
  }

  // The polygons of the lines as one job, in the words of packets; an END behind each object.
  make() {
    const lines = $("points").value.split("\n").map((line) => line.trim()).filter(Boolean), rows = [];
    for (const line of lines) {
      const points = line.split(/\s+/).map((each) => /^(\d+(?:\.\d+)?),(\d+(?:\.\d+)?)$/.exec(each));
      if (points.length < 2 || points.includes(null)) { this.page.say(_("An object is two points or more, x,y in mm: {line}", { line })); return; }
      points.forEach(([, x, y], n) => rows.push(`${n ? "LINE" : "MOVE"} ${Math.round(x * this.scale[0])} ${Math.round(y * this.scale[1])}`));
      rows.push("END");
    }
    if (rows.length) this.page.upload(new File([`${rows.join("\n")}\n`], "points.txt"));
  }

  // How long each object takes, while a job of several is drawn: by the lines that are its ENDs.
  time(now) {
    const ends = (this.ends || []).filter((line) => now.line > line || now.how === "done").length, at = performance.now();
    if (now.how !== "run" && now.how !== "done" || !this.ends || this.ends.length < 2) { this.begun = null; return; }
    if (now.how === "run" && (this.begun === null || this.begun === undefined || ends < this.times.length)) { this.begun = at; this.times = []; }
    while (this.begun !== null && this.begun !== undefined && this.times.length < ends) { this.times.push((at - this.begun) / 1000); this.begun = at; }
    const text = this.times.map((seconds, n) => _("Object {n}: {seconds} s", { n, seconds: seconds.toFixed(1) }));
    if ($("object-times").dataset.shown === text.join()) return;
    $("object-times").dataset.shown = text.join();
    $("object-times").replaceChildren(...text.map((each) => Object.assign(document.createElement("li"), { textContent: each })));
  }

  // Moves of the picture in mm.
  read(text) {
    const moves = [];
    let from = [0, 0];
    this.ends = [];
    text.split("\n").forEach((row, index) => {
      const [word, x, y] = row.split("#")[0].trim().toUpperCase().split(/\s+/);
      if (word === "END") this.ends.push(index + 1);
      if (word !== "MOVE" && word !== "LINE") return;
      const to = [Number(x) / this.scale[0], Number(y) / this.scale[1]];
      moves.push({ line: index + 1, points: [from, to], rapid: word === "MOVE" });
      from = to;
    });
    return moves;
  }

  show(report, why) {
    const pen = { up: _("up"), down: _("down") }[report.pen] || _("not known");
    const { min, max, unit } = this.speed, speeds = `${min} … ${max} ${unit === "half_period_us" ? _("µs a half step: more is slower") : unit}`;
    for (const [name, value] of [["draw-speed-unit", speeds], ["pen", pen], ["drawn", report.drawn || 0], ["room", report.free === undefined ? "" : report.free]]) {
      if ($(name).textContent !== String(value)) $(name).textContent = value;
    }
    const now = report.job || {};
    this.time(now);
    const mine = report.link && report.owner !== "guest";
    const back = why.mine || (mine && report.state === "Idle" && now.back ? "" : why.idle || _("No job is under way."));
    const run = why.mine || (mine && now.how === "run" && now.single ? "" : _("No job is under way."));
    for (const [what, text] of [["run", run], ["back", back], ["step_back", back]]) grey(document.querySelector(`#card-plotter [data-play=${what}]`), text);
    grey($("draw-speed-form").querySelector("button"), why.idle);
  }
}
