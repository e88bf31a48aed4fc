// Cards that only some languages have, and what a job is in a language other than G-code.

import { Keys } from "./card_keys.js";
import { Plotter } from "./card_plotter.js";
import { PulseFile } from "./card_pulses.js";
import { Torch } from "./card_torch.js";
import { grey, onOff } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
// What a machine and its language may lack.
const LACKS = { place: "the position", home: "seeking the origin", zero: "a zero of the work", goto: "going to a place", jobs: "jobs", hold: "pause",
  single: "single steps", teach: "teach-in", outputs: "spindle and coolant", overrides: "overrides", signals: "input signals",
  line: "a command line", settings: "settings" };
// What only a PC computes: shown greyed where there is none. [word of the machine, its name, languages]
const ELSEWHERE = [["from", "Begin at a line", ["grbl"]], ["queue", "Queue", ["grbl", "plotter", "pulses"]], ["place", "Place the drawing", ["grbl", "plotter"]]];
const OWN = { keys: Keys, plotter: Plotter, pulses: PulseFile, torch: Torch };

export class Cards {
  // page: { order(name, fields), ask(text), picture, report(), proven(), until(wanted) }
  constructor(page) {
    this.page = page;
    this.own = null;
    this.words = [];
    for (const button of document.querySelectorAll("[data-play]")) button.onclick = () => page.order("play", { what: button.dataset.play });
    for (const button of document.querySelectorAll("[data-switch]")) button.onclick = () => page.order("output", { name: button.dataset.switch });
    $("single").onclick = () => this.single();
  }

  can(what) { return this.words.includes(what); }

  // What the machine can, and what its board file says.
  hello(message) {
    this.words = message.can;
    for (const card of document.querySelectorAll("[data-can]")) card.hidden = !card.dataset.can.split(" ").some((what) => this.can(what));
    this.language = message.language;
    this.tellElsewhere();
    $("teach-name").value = message.language === "pulses" ? "taught.txt" : "taught.gcode";
    this.own = message.language in OWN ? new OWN[message.language](this.page, message) : null;
  }

  // A job's text: the moves of its picture, or null if it is G-code.
  read(text) { return this.own && this.own.read ? this.own.read(text) : null; }

  // True if the list of what is under way is shown here.
  mark(now) { return Boolean(this.own && this.own.mark && this.own.mark(now)); }

  // What is said of a job; null: as of G-code, and of one that the board keeps.
  told(now) { return !now.stored && this.own && this.own.told ? this.own.told(now) : null; }

  // `why`: of what is grey.
  show(report, why) {
    const now = report.job;
    const busy = Boolean(now) && ["load", "run", "halting"].includes(now.how);
    const mine = report.link && report.owner !== "guest";
    grey($("single"), why.mine || why.chosen || (report.link && busy && !now.checked ? "" : why.idle));
    if (busy && now.single && mine) grey($("resume"), "");
    const switches = why.mine || (mine && ["Idle", "Hold", "Alarm"].includes(report.state) ? "" : why.rest);
    for (const button of document.querySelectorAll("[data-switch]")) grey(button, switches);
    for (const mark of document.querySelectorAll("[data-shows]")) {
      const text = onOff(mark.dataset.shows, report[mark.dataset.shows]);
      if (mark.textContent !== text) mark.textContent = text;
    }
    this.tellLacks();
    if (this.own) this.own.show(report, why);
  }

  // What a PC would do is greyed, and why.
  tellElsewhere() {
    const names = ELSEWHERE.filter(([what, , spoken]) => spoken.includes(this.language) && !this.can(what)).map(([, name]) => name);
    $("elsewhere").hidden = !names.length || !this.can("jobs") && !this.can("kept");
    $("elsewhere-list").replaceChildren(...names.map((name) => Object.assign(document.createElement("button"), { type: "button", disabled: true, textContent: _(name) })));
  }

  // What is hidden, and why.
  tellLacks() {
    const lacks = Object.keys(LACKS).filter((what) => !this.can(what) && !(what === "jobs" && this.can("kept"))).map((what) => _(LACKS[what]));
    const text = lacks.length ? _("This machine speaks {language}. Hidden, because it has no word for it: {lacks}.", { language: this.language, lacks: lacks.join(", ") }) : "";
    if ($("lacks").textContent !== text) $("lacks").textContent = text;
  }

  // One line, or one code, and no more. A job that does not run yet begins so.
  async single() {
    const now = this.page.report().job;
    if (!now || !["run", "load"].includes(now.how)) {
      const begun = await this.page.order("run", { name: $("jobs").value, passes: Number($("passes").value) || 1, single: true });
      if (begun.error || !await this.page.until((job) => job && job.how === "run")) return;
    }
    this.page.order("play", { what: "step" });
  }
}
