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
    $("draw-speed-form").onsubmit = (event) => { event.preventDefault(); page.order("pace", { speed: Number(field.value) }); };
  }

  // Moves of the picture in mm.
  read(text) {
    const moves = [];
    let from = [0, 0];
    text.split("\n").forEach((row, index) => {
      const [word, x, y] = row.split("#")[0].trim().toUpperCase().split(/\s+/);
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
    const mine = report.link && report.owner !== "guest";
    const back = why.mine || (mine && report.state === "Idle" && now.back ? "" : why.idle || _("No job is under way."));
    const run = why.mine || (mine && now.how === "run" && now.single ? "" : _("No job is under way."));
    for (const [what, text] of [["run", run], ["back", back], ["step_back", back]]) grey(document.querySelector(`#card-plotter [data-play=${what}]`), text);
    grey($("draw-speed-form").querySelector("button"), why.idle);
  }
}
