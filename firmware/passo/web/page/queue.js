// The jobs that wait for one another, and all jobs with their pictures.

import { grey } from "./controls.js";
import { clock } from "./job_facts.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const MOST_PICTURES = 60, MOST_CHARACTERS = 400000;  // a longer job has no picture in the list
const WIDE = 132, HIGH = 88;

export class Queue {
  // order(name, fields): a promise of the answer; page: { job(): the chosen one's name, choose(name), text(name, most): its text, about(name): a promise of what it will do, moves(text) }.
  constructor(order, page) {
    this.order = order;
    this.page = page;
    this.known = new Map();  // name and size: the moves of a picture
    this.times = new Map();  // name and size: seconds, where somebody computes them
    $("queue-add").onclick = () => this.ask("add", { name: page.job() });
    $("queue-run").onclick = () => this.ask("run");
    $("queue-clear").onclick = () => this.ask("clear");
    $("pictures-row").firstElementChild.addEventListener("toggle", () => this.draw());
  }

  ask(what, more = {}) { return this.order("queue", { what, ...more }); }

  // `queue`: the state's; `why`: of what is grey.
  show(queue, why) {
    if (!queue) return;
    const empty = queue.jobs.length ? "" : _("The queue is empty.");
    grey($("queue-add"), why.chosen);
    grey($("queue-run"), why.mine || why.idle || empty);
    grey($("queue-clear"), empty);
    const told = JSON.stringify(queue.jobs) + document.documentElement.lang;
    if (told === this.told) return;
    this.told = told;
    $("queue-count").textContent = queue.jobs.length ? `(${queue.jobs.length})` : "";
    $("queue").replaceChildren(...queue.jobs.map((name, at) => {
      const item = document.createElement("li"), text = document.createElement("span");
      text.textContent = name;
      item.append(text);
      for (const [what, sign, label] of [["up", "↑", _("{name}: earlier", { name })], ["down", "↓", _("{name}: later", { name })],
        ["remove", "×", _("{name}: out of the queue", { name })]]) {
        const button = document.createElement("button");
        Object.assign(button, { type: "button", textContent: sign, disabled: what === "up" && !at || what === "down" && at === queue.jobs.length - 1 });
        button.setAttribute("aria-label", label);
        button.onclick = () => this.ask(what, { at, name });
        item.append(button);
      }
      return item;
    }));
  }

  // What the queue waits for, and what the button says; null: nothing.
  static waits(report) {
    const { waits, jobs, tool } = report.queue || {};
    if (!waits || !jobs.length) return null;
    const name = jobs[0];
    const text = waits === "tool" ? _("Next: {name}. Put in tool {tool}, set its zero, then go on.", { name, tool })
      : waits === "gone" ? _("Next: {name}, which is not here any more: take it out of the queue.", { name }) : _("Next: {name}. Is all ready for it?", { name });
    return [text, _("Run {name}", { name })];
  }

  // The list of all jobs: [[name, bytes]].
  take(jobs) {
    this.jobs = jobs;
    this.draw();
  }

  async draw() {
    if (!$("pictures-row").firstElementChild.open || !this.jobs || this.shown === this.jobs) return;
    const jobs = this.shown = this.jobs;
    $("pictures").replaceChildren();
    for (const [name, size] of jobs.slice(0, MOST_PICTURES)) {
      const key = `${name} ${size}`, item = document.createElement("li"), button = document.createElement("button"), text = document.createElement("span");
      button.type = "button";
      text.textContent = `${name} (${Math.ceil(size / 1024)} kB)`;
      const canvas = Object.assign(document.createElement("canvas"), { width: 2 * WIDE, height: 2 * HIGH });
      canvas.setAttribute("aria-hidden", "true");
      button.append(canvas, text);
      button.onclick = () => this.page.choose(name);
      item.append(button);
      $("pictures").append(item);
      if (size <= MOST_CHARACTERS && !this.known.has(key)) this.known.set(key, this.page.moves(await this.page.text(name, MOST_CHARACTERS)));
      if (this.shown !== jobs) return;
      const box = thumb(canvas, this.known.get(key) || []);
      if (!this.times.has(key)) this.times.set(key, (await this.page.about(name)).seconds);
      if (this.shown !== jobs) return;
      const facts = document.createElement("small"), seconds = this.times.get(key);
      facts.textContent = [seconds === undefined ? "" : clock(seconds), box && _("{width} × {height} mm", { width: (box[1] - box[0]).toFixed(1), height: (box[3] - box[2]).toFixed(1) })]
        .filter(Boolean).join(" · ");
      button.append(facts);
    }
  }
}

// All of a path, seen from above, as large as it fits. Its box: [low x, high x, low y, high y], or null.
function thumb(canvas, moves) {
  const ink = canvas.getContext("2d"), box = [Infinity, -Infinity, Infinity, -Infinity], cuts = moves.filter((move) => !move.rapid);
  for (const { points } of cuts) for (const [x, y] of points) {
    box[0] = Math.min(box[0], x); box[1] = Math.max(box[1], x); box[2] = Math.min(box[2], y); box[3] = Math.max(box[3], y);
  }
  if (!cuts.length) return null;
  const scale = 0.9 * Math.min(canvas.width / (box[1] - box[0] || 1), canvas.height / (box[3] - box[2] || 1));
  const at = ([x, y]) => [canvas.width / 2 + (x - (box[0] + box[1]) / 2) * scale, canvas.height / 2 - (y - (box[2] + box[3]) / 2) * scale];
  ink.clearRect(0, 0, canvas.width, canvas.height);
  ink.beginPath();
  for (const { points } of cuts) points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...at(point)));
  Object.assign(ink, { strokeStyle: getComputedStyle(document.documentElement).getPropertyValue("--path").trim(), lineWidth: 2 });
  ink.stroke();
  return box;
}
