// A live test of inputs and outputs: what each input says now, whether it has been seen both ways, and outputs one by one.

import { button, make, note, setText } from "./setup_parts.js";
import { _ } from "./words.js";

const inputs = () => ({ X: _("Limit X"), Y: _("Limit Y"), Z: _("Limit Z"), A: _("Limit A"), P: _("Probe"), D: _("Door"), H: _("Hold button"), R: _("Reset button"), S: _("Start button") });
const outputs = () => [["spindle_cw", _("Tool on"), "S"], ["spindle_ccw", _("Tool reversed"), "C"], ["spindle_off", _("Tool off")], ["flood", _("Flood"), "F"], ["mist", _("Mist"), "M"], ["coolant_off", _("Coolant off")]];

export class InOut {
  constructor(setup) {
    this.setup = setup;
    const axes = setup.page.axes().toUpperCase();
    this.rows = Object.entries(inputs()).filter(([letter]) => !"XYZA".includes(letter) || axes.includes(letter)).map(([letter, name]) => this.lamp(letter, name));
    this.rpm = make("input", { type: "number", min: 0, max: 100000, value: 1000, inputMode: "numeric" });
    this.buttons = outputs().map(([name, text, letter]) => ({ letter, node: button(text, () => this.set(name)) }));
    this.named = {};  // rows of the inputs of an interlock, which have names and no letters: each from its first change on
    this.lamps = make("ul", { className: "lamps" }, ...this.rows.map(({ node }) => node));
    this.node = make("div", {}, note(_("Press each switch by hand: its lamp is to light, and to go out again.")), this.lamps,
      make("h3", { textContent: _("Outputs") }), make("label", { className: "line" }, make("span", { textContent: _("Speed of the tool, rpm") }), this.rpm),
      make("p", { className: "row fill" }, ...this.buttons.map(({ node }) => node)));
    this.sure = false;
  }

  lamp(letter, name) {
    const state = make("b"), seen = make("span", { className: "seen" });
    return { letter, was: null, changes: 0, state, seen, node: make("li", { className: "lamp" }, make("span", { className: "grow", textContent: name }), state, seen) };
  }

  // The inputs that an interlock names: those that forbid something now.
  forbidding(report) {
    const told = (report.more || []).find(([word]) => word === "Fb"), names = told ? told[1].split(",") : [];
    for (const name of names) {
      if (name in this.named) continue;
      this.named[name] = this.lamp(name, name.replace("(", " ("));
      this.named[name].was = false;
      this.lamps.append(this.named[name].node);
    }
    return names;
  }

  // The first output asks: things move and spray.
  async set(name) {
    const { page } = this.setup;
    if (!this.sure && !name.endsWith("off") && !(await page.ask(_("Outputs switch at once. Is nobody near the tool?")))) return;
    this.sure = true;
    page.order("output", { name, rpm: Number(this.rpm.value) || 0 });
  }

  show(report) {
    const forbid = this.forbidding(report);
    for (const row of [...this.rows, ...Object.values(this.named)]) {
      const on = row.letter in this.named ? forbid.includes(row.letter) : (report.pins || "").includes(row.letter);
      if (row.was !== null && row.was !== on) row.changes++;
      row.was = on;
      row.node.dataset.lamp = on ? "closed" : row.changes > 1 ? "seen" : "";
      setText(row.state, on ? _("on") : _("off"));
      setText(row.seen, row.changes > 1 ? _("seen both ways, {count} changes", { count: row.changes }) : row.changes ? _("one change") : "");
    }
    const why = this.setup.why(false);
    for (const { letter, node } of this.buttons) {
      node.disabled = Boolean(why);
      if (letter) node.setAttribute("aria-pressed", String((report.on || "").includes(letter)));
    }
  }

  close() {}
}
