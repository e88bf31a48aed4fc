// What is told of a job before and while it runs: size, time, bounds, tools; gone, left, and when it ends.

import { programLines } from "./program.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const TRUST = 0.1;  // part of a job up to which the estimate counts for more than what was measured
const RATE_S = 3;  // over which lines a second are counted
const LOW = 10;  // % of the board's queue: with less the machine slows down to the pace of its lines

// What is said of a letter that is none of G-code, as programLines() and the board name it.
export function wrongLetter({ line, letter }) {
  const code = `U+${letter.codePointAt(0).toString(16).toUpperCase().padStart(4, "0")}`;
  return _("Line {line}: “{letter}” ({code}) is no letter of G-code: only a comment may have it", { line, letter, code });
}

// Seconds as people say them.
export function clock(seconds) {
  const s = Math.round(seconds), two = (number) => String(number).padStart(2, "0");
  return s < 3600 ? `${Math.floor(s / 60)}:${two(s % 60)} min` : `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)} h`;
}

export class JobFacts {
  // order(name, fields): a promise of the answer; picture: its bounds and table; known(about): what is known of the job is another;
  // errorText(number): what an error says.
  constructor(order, picture, known, errorText) {
    this.known = known;
    this.errorText = errorText;
    this.beyond = "";  // what leads out of the table, in words
    this.order = order;
    this.picture = picture;
    this.about = {};
    this.run = null;
  }

  // A job has been loaded: ask the PC what it will do; a board has no time for that.
  async load(job) {
    const { last, behind, wrong } = job.language === "grbl" ? programLines(job.text) : {};
    this.about = { name: job.name, size: job.text.length, lines: job.lines.length, last, behind, wrong };
    this.tell();
    const answer = await this.order("job_about", { name: job.name });
    if (!answer.error && answer.name === this.about.name) this.about = { ...this.about, ...answer };
    this.tell();
  }

  clear() { this.about = {}; this.tell(); }

  tell() {
    this.known(this.about);
    const { name, size, lines, seconds, tools, pauses } = this.about, box = name && this.picture.bounds();
    const kB = { lines, size: Math.ceil(size / 1024) };
    const facts = name ? [lines === 1 ? _("1 line, {size} kB", kB) : _("{lines} lines, {size} kB", kB)] : [];
    if (seconds !== undefined) facts.push(_("about {time}", { time: clock(seconds) }));
    const told = (ends, axis) => (axis < 2 || ends.some(Boolean) ? [`${"XYZ"[axis]}\u00a0${ends[0].toFixed(1)}\u00a0…\u00a0${ends[1].toFixed(1)}`] : []);  // a plotter has no Z
    if (tools && seconds === undefined) facts.push(_("too long for an estimate here: passo check tells the time"));
    if (box) facts.push([].concat(...box.map(told)).join(", ") + " mm");
    if (tools && tools.length) facts.push(_("tools {tools}", { tools: tools.join(", ") }));
    if (pauses) facts.push(_("pauses: {pauses}", { pauses }));
    if ($("job-facts").textContent !== facts.join(" · ")) $("job-facts").textContent = facts.join(" · ");
    const { refused, advice, last, behind, wrong: letter } = this.about, line = refused && refused[0];
    this.beyond = box ? this.outside(box) : "";
    const ends = behind ? _("The program ends at line {last}; {behind} lines behind it are no part of it", { last, behind }) : "";
    const wrong = [letter ? wrongLetter(letter) : "", ends, refused ? `${_("The job would stop at line {line}.", { line })} ${this.errorText(refused[1])}` : "", refused && advice, this.beyond].filter(Boolean).join(". ");
    if ($("job-wrong").textContent !== wrong) $("job-wrong").textContent = wrong;
  }

  // What leads out of the table, in words.
  outside(box) {
    const table = this.picture.table;
    if (!table) return "";
    const wrong = box.map(([low, high], axis) => {
      const [least, most] = table.box[axis];
      if (most <= least || low >= least - 0.01 && high <= most + 0.01) return "";
      return `${"XYZ"[axis]} ${low.toFixed(1)} … ${high.toFixed(1)} mm (${_("travel")} ${least.toFixed(1)} … ${most.toFixed(1)} mm)`;
    }).filter(Boolean);
    return wrong.length ? _("From this zero it goes out of the travel: {axes}", { axes: wrong.join(", ") }) : "";
  }

  // The times and the pace of a job that runs; `now`: the job of the state `report`.
  show(now, report) {
    const runs = now && ["run", "halting"].includes(now.how) && !now.checked;
    if (!runs) {
      if (!now || now.how !== "done") $("job-time").textContent = "";
      else if (this.run) $("job-time").textContent = [_("{time} gone", { time: clock((Date.now() - this.run.from) / 1000) }), ...this.waits()].join(", ");
      this.run = null;
      return;
    }
    if (!this.run || this.run.name !== now.name || now.done < this.run.done) this.run = { name: now.name, from: Date.now(), at: now.done, seen: [], low: true, lows: [] };
    this.run.done = now.done;
    const gone = (Date.now() - this.run.from) / 1000, left = this.left(now, gone);
    let text = _("{time} gone", { time: clock(gone) });
    if (left !== null) {
      const end = new Date(Date.now() + left * 1000).toLocaleTimeString(document.documentElement.lang, { hour: "2-digit", minute: "2-digit" });
      text += `, ${_("about {time} left, ends at {end}", { time: clock(left), end })}`;
    }
    text = [text, ...this.pace(now, report), ...this.waits()].join(", ");
    if ($("job-time").textContent !== text) $("job-time").textContent = text;
  }

  // Lines a second, of the last seconds, and how full the board's queue is.
  pace(now, report) {
    const { seen, lows } = this.run, at = Date.now() / 1000, line = now.stored ? report.line : now.done, told = [];
    if (seen.length && line < seen[seen.length - 1][1]) seen.length = 0;  // the next pass
    seen.push([at, line]);
    while (at - seen[0][0] > RATE_S) seen.shift();
    const seconds = at - seen[0][0];
    if (seconds > 1) told.push(_("{rate} lines a second", { rate: Math.round((line - seen[0][1]) / seconds) }));
    if (typeof report.full !== "number") return told;
    const low = report.full < LOW;
    if (low && !this.run.low && report.state === "Run" && now.done < now.lines) lows.push(report.line || line);
    this.run.low = low;
    return [...told, _("queue {percent} %", { percent: report.full })];
  }

  // Where the board's queue was nearly empty.
  waits() {
    const { lows } = this.run;
    return lows.length ? [_("waits for lines: {count}, the first at line {line}", { count: lows.length, line: lows[0] })] : [];
  }

  // Seconds left, by the estimate and the pace so far; null: nobody knows.
  left(now, gone) {
    const { name, parts, seconds } = this.about, share = now.lines ? now.done / now.lines : 0;
    if (name !== now.name || !parts || !seconds) return share > 0.03 && gone > 5 ? gone * (1 - share) / share : null;
    const until = (part) => {
      const at = Math.min(1, part) * (parts.length - 1), low = Math.floor(at);
      return parts[low] + (at - low) * ((low + 1 < parts.length ? parts[low + 1] : parts[low]) - parts[low]);
    };
    const thought = until(share), begun = until(this.run.at / now.lines), trust = seconds * TRUST;
    return (seconds - thought) * (gone + trust) / (thought - begun + trust) + seconds * (now.passes - now.pass);
  }
}

// A file that is dropped anywhere on the page; take(file).
export function dropped(take, may) {
  const show = (on) => document.body.classList.toggle("dropping", on);
  document.addEventListener("dragover", (event) => { event.preventDefault(); show(may()); });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) show(false); });
  document.addEventListener("drop", async (event) => {
    event.preventDefault();
    show(false);
    for (const file of may() ? Array.from(event.dataTransfer.files) : []) await take(file);
  });
}
