// How well homing repeats, what encoders miss, and what noise inputs have seen: figures of the board as small plots.

import { button, make, note, setText } from "./setup_parts.js";
import { _ } from "./words.js";

const MOST = 60;  // readings of an encoder that are kept
const NS = "http://www.w3.org/2000/svg";

// A bar of `part` of the longest.
function bar(part, kind) {
  const drawn = document.createElementNS(NS, "svg"), filled = document.createElementNS(NS, "rect");
  drawn.setAttribute("class", `bar ${kind}`);
  drawn.setAttribute("viewBox", "0 0 100 10");
  drawn.setAttribute("preserveAspectRatio", "none");
  drawn.setAttribute("aria-hidden", "true");
  for (const [name, value] of [["width", Math.max(1, 100 * part)], ["height", 10]]) filled.setAttribute(name, value);
  drawn.append(filled);
  return drawn;
}

// A line through values around zero.
function line(values) {
  const drawn = document.createElementNS(NS, "svg"), way = document.createElementNS(NS, "polyline"), most = Math.max(1, ...values.map(Math.abs));
  drawn.setAttribute("class", "bar");
  drawn.setAttribute("viewBox", `0 ${-most - 0.5} ${MOST} ${2 * most + 1}`);
  drawn.setAttribute("preserveAspectRatio", "none");
  drawn.setAttribute("aria-hidden", "true");
  way.setAttribute("points", values.map((value, n) => `${n},${-value}`).join(" "));
  drawn.append(way);
  return drawn;
}

const row = (name, drawn, text) => make("li", {}, make("b", { textContent: name }), drawn, make("span", { textContent: text }));

export class Health {
  constructor(setup) {
    this.setup = setup;
    this.series = {};
    this.lists = ["homing", "encoders", "noise"].map(() => make("ul", { className: "plots" }));
    this.home = button(_("Home ten times, and compare"), () => this.homing());
    this.read = button(_("Read now"), () => this.reading());
    this.noteHome = note(_("It shows the range of each switch in steps, and what to change."));
    const [homing, encoders, noise] = this.lists;
    this.node = make("div", {}, make("h3", { textContent: _("Homing") }), homing, this.noteHome, make("p", { className: "row fill" }, this.home),
      make("h3", { textContent: _("Encoders: steps off") }), encoders, make("h3", { textContent: _("Noise on inputs: glitches, stops") }), noise,
      make("p", { className: "row fill" }, this.read));
    this.state = "";
    this.reads = false;
  }

  async homing() {
    if (!(await this.setup.page.ask(_("The machine homes eleven times. Is the way free?")))) return;
    this.home.disabled = true;
    const told = [];
    const why = await this.setup.run([{ line: () => "$HR=10", answer: (said) => told.push(...said), text: "" }]);
    const found = told.filter((text) => text.slice(0, 5) === "[HOM:").map((text) => text.slice(5, -1).split(","));
    const most = Math.max(1, ...found.map(([, , range]) => Number(range)));
    this.lists[0].replaceChildren(...found.map(([axis, , range, sigma, ...advice]) => row(axis.toUpperCase(), bar(range / most, range > 1 ? "bad" : "good"),
      _("{range} steps, σ {sigma}: {advice}", { range, sigma, advice: this.advice(advice.join(",")) }))));
    if (!why && !found.length) setText(this.noteHome, _("The board does not measure it: its board file says no latch for homing."));
  }

  // What the board advises, in the page's language.
  advice(text) {
    if (text === "good") return _("good");
    return text.slice(0, 6) === "drifts" ? _("drifts: steps are lost; lower $25, or the acceleration") : _("scatters: lower $24, raise $26, or clean the switch");
  }

  async reading() {
    if (this.reads || this.setup.lines.waiting) return;
    this.reads = true;
    const has = (this.setup.page.report().more || []).some(([word]) => word === "En");
    const counts = has ? await this.setup.lines.say("$ENC") : { said: [] }, log = await this.setup.lines.say("$LOG");
    this.reads = false;
    this.encoders(counts.said.filter((text) => text.slice(0, 5) === "[ENC:").map((text) => text.slice(5, -1).split(",")));
    this.noise(log.said.filter((text) => text.slice(0, 5) === "[PIN:").map((text) => text.slice(5, -1).split(",")));
  }

  encoders(found) {
    const list = this.lists[1];
    if (!found.length) return list.replaceChildren(make("li", { className: "note", textContent: _("This machine has none.") }));
    list.replaceChildren(...found.map(([motor, , off, most]) => {
      this.series[motor] = (this.series[motor] || []).concat(Number(off)).slice(-MOST);
      return row(motor.toUpperCase(), line(this.series[motor]), _("{off} now, at most {most}", { off, most }));
    }));
    return null;
  }

  noise(found) {
    const list = this.lists[2];
    if (!found.length) return list.replaceChildren(make("li", { className: "note", textContent: _("None seen, or the board file has no interlock, which counts them.") }));
    const most = Math.max(1, ...found.map(([, , , glitches]) => Number(glitches)));
    list.replaceChildren(...found.map(([name, , trips, glitches]) => row(name, bar(glitches / most, Number(glitches) ? "bad" : "good"), _("{glitches} glitches, {trips} stops", { glitches, trips }))));
    return null;
  }

  show(report) {
    const why = this.setup.why(false);
    this.home.disabled = Boolean(why);
    this.read.disabled = Boolean(why) || this.reads;
    if (report.state !== this.state && !why && !this.setup.lines.waiting) {  // it has come to rest: another reading
      this.state = report.state;
      this.reading();
    } else if (report.state !== "Idle") this.state = report.state;
  }

  close() {}
}
