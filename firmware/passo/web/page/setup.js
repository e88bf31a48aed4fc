// Set-up: the work's zeros, wizards, tests. A script of its own, which the page loads once somebody opens the part.

import { Health } from "./setup_health.js";
import { InOut } from "./setup_inout.js";
import { Lines } from "./setup_lines.js";
import { Offsets } from "./setup_offsets.js";
import { Pad } from "./setup_pad.js";
import { button, make } from "./setup_parts.js";
import { Scene } from "./setup_scene.js";
import { Wizard } from "./setup_wizard.js";
import { wizards } from "./setup_wizards.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const AGAIN_MS = 2000;
const BUSY_JOB = ["load", "run", "halting", "store"];

// What there is: [key, name, view(setup)].
function parts() {
  const found = wizards();
  const wizard = (key) => [key, found[key].title, (setup) => new Wizard(setup, key, found[key])];
  return [["offsets", _("Work offsets"), (setup) => new Offsets(setup)], ...["plate", "corner", "hole", "boss", "tool"].map(wizard),
    ["surface", _("Surfacing"), (setup) => computed(setup, "Surfacing")], ["map", _("Height map"), (setup) => computed(setup, "HeightMap")],
    ["inout", _("Inputs and outputs"), (setup) => new InOut(setup)], ["health", _("Homing, encoders, noise"), (setup) => new Health(setup)],
    ["pad", _("Gamepad and camera"), (setup) => new Pad(setup)]];
}

// What a PC or a tab computes: its script is there where something computes, else the reason why not.
function computed(setup, name) {
  if (window.PassoMake) return new window.PassoMake[name](setup);
  const node = make("div", {}, make("p", { className: "reason", textContent: _("A board alone cannot compute this: it has no Python beside its firmware. Open the page of passo panel on a PC, or try it in the browser's tab.") }));
  return { node, show: () => {}, close: () => {} };
}

// The wizards' pictures, small.
function thumbnails() {
  const found = {}, all = wizards();
  for (const key of Object.keys(all)) {
    const spec = all[key], scene = new Scene(""), p = {};
    for (const field of spec.fields) p[field.name] = field.value;
    scene.draw(spec.shapes(p), spec.start(p), spec.steps(p, 0), spec.tool(p));
    scene.node.setAttribute("aria-hidden", "true");
    found[key] = scene.node;
  }
  return found;
}

class Setup {
  // page: { send(name, fields), order(name, fields), ask(text), report(), axes(), settings(), range(), can(what), busy(), errorText(number), stop(), look(on), chosen(name), jog(way, part, of), letGo(of), placed(), jobs() }
  constructor(page) {
    this.page = page;
    this.lines = new Lines(page);
    this.facts = null;
    this.known = "";
    this.later = 0;
    this.view = null;
    this.speak();
  }

  // The list of what there is, in the language of now.
  speak() {
    if (this.view) this.view.close();
    this.view = null;
    this.chosen = "";
    this.placed();
    this.parts = parts();
    const pictures = thumbnails();
    $("setup-title").textContent = _("Set up");
    $("setup").replaceChildren(make("div", { className: "tiles" }, ...this.parts.map(([key, name]) => {
      const tile = button(name, () => this.choose(key), "tile");
      tile.id = `setup-${key}`;
      if (["surface", "map"].includes(key) && !window.PassoMake) tile.classList.add("grey");
      if (pictures[key]) tile.prepend(pictures[key]);
      return tile;
    })));
  }

  choose(key) {
    const [, name, view] = this.parts.find(([each]) => each === key);
    const back = button(_("All of the set-up"), () => { const from = this.chosen; this.speak(); $(`setup-${from}`).focus(); }, "back");
    back.id = "setup-back";
    this.chosen = key;
    this.placed();
    this.view = view(this);
    $("setup-title").textContent = name;
    $("setup").replaceChildren(back, this.view.node);
    this.known = "";
    this.show();
    back.focus();
    $("card-setup").scrollIntoView({ block: "nearest" });
  }

  placed() {
    document.body.dataset.setup = this.chosen;
    this.page.placed();
  }

  // What the board has said; true: an answer that only this script has asked for.
  heard(text) { return this.lines.heard(text); }

  // STOP was pressed here, or the link is lost.
  halt() { if (this.lines.runs) this.lines.halt(_("Stopped.")); }

  locked() { return this.lines.runs; }

  show() {
    if (this.view || window.PassoMake) this.look();  // a board computes less unasked
    if (!this.view) return;
    this.page.look(this.lines.runs);
    this.view.show(this.page.report());
  }

  // Ask the board anew for its offsets once they, or the state, are others.
  look() {
    const { state, m, w } = this.page.report();
    const now = JSON.stringify([state, (m || []).map((value, n) => (value - w[n]).toFixed(3))]);
    if (now === this.known || !["Idle", "Alarm"].includes(state) || this.lines.runs || this.lines.waiting || this.page.busy() || Date.now() < this.later) return;
    this.known = now;
    this.lines.facts().then((facts) => this.learn(facts));
  }

  // What $# and $G have told; null: refused, it is asked again later.
  learn(facts) {
    this.facts = facts;
    if (!facts) [this.known, this.later] = ["", Date.now() + AGAIN_MS];
    else this.page.offsets(Object.entries(facts.systems).filter(([name, place]) => name !== facts.active && place.some(Boolean)));
    if (this.view) this.view.show(this.page.report());
  }

  range(axis) { return (this.page.range() || [])[axis] || null; }

  low() { return (this.range(2) || [0, 0])[0]; }

  top() { return (this.range(2) || [0, 0])[1]; }

  // How far Z can go up from here, mm; 0: not known.
  room() {
    const { m } = this.page.report();
    return this.range(2) && m && m.length > 2 ? Math.max(0, this.top() - m[2]) : 0;
  }

  unhomed() {
    return Number(this.page.settings()[22]) && this.facts && this.facts.homed === false ? _("The machine is not homed. Home it first.") : "";
  }

  // Why nothing may begin now, "" if it may. `probing`: it touches.
  why(probing) {
    const report = this.page.report(), job = report.job;
    if (this.lines.runs) return _("It is under way. STOP ends it.");
    if (report.owner === "guest") return _("Another program moves the machine.");
    if (this.page.busy() || job && BUSY_JOB.includes(job.how)) return _("A job is under way.");
    if (report.state !== "Idle") return _("The machine is not at rest, or locked.");
    if (Number(this.page.settings()[13])) return _("The board reports in inches ($13): set it to 0.");
    if (!probing) return "";
    if (this.page.axes().length < 3) return _("It wants three axes.");
    if (this.unhomed()) return this.unhomed();
    if ((report.pins || "").includes("P")) return _("The probe is closed already. Take the plate off the tool, or see $6.");
    return /[SC]/.test(report.on || "") ? _("The tool turns. Switch it off.") : "";
  }

  // Steps to their end, told(index). Returns "" or why they ended.
  async run(steps, told = () => {}) {
    if (this.why(false)) return this.why(false);
    const running = this.lines.run(steps, told);
    this.show();
    const why = await running;
    this.known = "";
    this.page.say(why);
    this.show();
    return why;
  }
}

window.PassoSetup = Setup;
