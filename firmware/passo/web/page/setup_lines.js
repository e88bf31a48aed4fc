// Lines of G-code one after the other, each answered and at rest before the next goes: what a wizard is made of.

import { _ } from "./words.js";

const AGAIN = [8, 108];  // errors of a machine that still has something to do
const HALTED = -1;
const RESTART = "Grbl";  // the board was reset: what was under way is forgotten
const AXES = "xyz";

const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const numbers = (text) => text.split(",").map(Number);

// G91 words of {axis: mm}.
export const words = (by) => Object.keys(by).map((axis) => `${axis.toUpperCase()}${by[axis].toFixed(3)}`).join("");

export class Lines {
  // page: send(name, fields), report(), errorText(number)
  constructor(page) {
    this.page = page;
    this.runs = false;
    this.halted = "";
    this.waiting = null;
    this.asks = false;
    this.asked = Promise.resolve();
    this.touched = {};
  }

  // What the board has said to this page. True: the answer of a question that is none of the user's.
  heard(text) {
    const quiet = this.asks && Boolean(this.waiting) && text.slice(0, 4) !== RESTART;
    if (text.slice(0, 4) === RESTART) this.halt(_("Stopped."));
    else if (this.waiting && text === "ok" && !(this.asks && !this.waiting.said.length)) this.waiting.end(0);  // else another order's: questions have answers
    else if (this.waiting && text.slice(0, 6) === "error:") this.waiting.end(Number(text.slice(6)));
    else if (this.waiting) this.waiting.said.push(text);
    return quiet;
  }

  // STOP, a lost link: no line goes any more.
  halt(why) {
    this.halted = why;
    if (this.waiting) this.waiting.end(HALTED);
  }

  once(line) {
    return new Promise((done) => {
      const said = [];
      const waiting = { said, end: (error) => { if (this.waiting === waiting) { this.waiting = null; done({ error, said }); } } };
      this.waiting = waiting;
      this.page.send("line", { line }).then((answer) => { if (answer.error) waiting.end(answer.error); });
    });
  }

  // The answer of a line, once there is room for it.
  async say(line) {
    for (;;) {
      const answer = this.halted && this.runs ? { error: HALTED, said: [] } : await this.once(line);
      if (!AGAIN.includes(answer.error) || this.page.report().state === "Alarm") return answer;
      await pause(150);
    }
  }

  // Text of why the machine is not at rest; "" once it is.
  async rest() {
    await pause(250);
    for (;;) {
      const { state, alarm } = this.page.report();
      if (this.halted) return this.halted;
      if (state === "Idle") return "";
      if (!["Run", "Jog", "Home", "Hold", "Door"].includes(state)) return alarm ? this.page.errorText(alarm) : _("Stopped.");
      await pause(100);
    }
  }

  // What $# and $G tell: { systems: {G54: [mm]}, active, shift, tool, tools, homed, inches, relative }, or null. Whoever asks waits for who asked before:
  // an answer to one is not taken for the other's.
  facts() {
    this.asked = this.asked.then(() => this.ask());
    return this.asked;
  }

  async ask() {
    const found = { systems: {}, tools: {}, homed: null };
    this.asks = true;
    for (const line of ["$#", "$G"]) {
      const answer = await this.say(line);
      if (answer.error) { this.asks = false; return null; }
      for (const text of answer.said) this.read(text, found);
    }
    this.asks = false;
    return found;
  }

  read(text, found) {
    const [name, value] = text.slice(1, -1).split(":");
    if (/^G5\d$/.test(name)) found.systems[name] = numbers(value);
    else if (name === "G92") found.shift = numbers(value);
    else if (name === "TLO") found.tool = Number(value);
    else if (/^T\d+$/.test(name)) found.tools[name.slice(1)] = Number(value);
    else if (name === "HOMED") found.homed = value === "1";
    else if (name === "GC") {
      const codes = value.split(" ");
      found.active = codes.find((code) => /^G5[4-9]$/.test(code));
      found.modes = codes.filter((code) => ["G20", "G21", "G90", "G91"].includes(code)).join("");
    }
  }

  // Run steps to their end; told(index). Returns "" or why it ended.
  // A step: { line } or { by: {axis: mm}, probe | free | neither: a rapid, feed, keep } or { set: (touched) => ({axis: mm of the work}), of: (touched) => ({axis: mm of the machine}) }
  async run(steps, told) {
    this.halted = "";
    this.runs = true;
    this.touched = {};
    const before = await this.facts();
    let why = before ? "" : _("The board does not answer.");
    for (let n = 0; n < steps.length && !why; n++) {
      told(n);
      why = await this.step(steps[n]);
    }
    if (before && !this.halted && this.page.report().state === "Idle") await this.say(before.modes);
    this.runs = false;
    return why;
  }

  async step(step) {
    const line = step.set ? await this.offset(step) : step.line ? step.line(this.touched) : this.move(step);
    if (!line) return this.halted || _("The board does not answer.");
    const answer = await this.say(line);
    if (this.halted) return this.halted;
    if (answer.error) return this.page.errorText(answer.error);
    if (step.answer) step.answer(answer.said);
    const why = await this.rest();
    return why || this.touch(step, answer.said.find((text) => text.slice(0, 5) === "[PRB:"));
  }

  move({ by, probe, free, feed }) {
    return `G21G91${probe ? `G38.2F${feed}` : free ? `G38.3F${feed}` : feed ? `G1F${feed}` : "G0"}${words(by)}`;
  }

  touch(step, told) {
    if (!step.probe && !step.free) return "";
    if (!told) return _("The board does not answer.");
    const [place, hit] = told.slice(5, -1).split(":");
    if (step.free && hit === "1") return _("Something is in the way: the probe touched where nothing was expected. Move away from it by hand.");
    if (step.keep) this.touched[step.keep] = numbers(place);
    return "";
  }

  // The line that makes a touched place of the machine a place of the work: exact, however far the tool went on behind it.
  async offset({ set, of }) {
    const facts = await this.facts();
    if (!facts || !facts.active) return "";
    const work = set(this.touched), machine = of(this.touched), axes = {};
    for (const axis of Object.keys(work)) {
      const n = AXES.indexOf(axis);
      axes[axis] = machine[axis] - work[axis] - (facts.shift[n] || 0) - (n === 2 ? facts.tool : 0);
    }
    return `G21G90G10L2P${Number(facts.active.slice(1)) - 53}${words(axes)}`;
  }
}
