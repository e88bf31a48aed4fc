// The board file of the chosen machine: made like another one, changed, taken back, deleted. Only a PC has files: no board has this script.

import { button, make, note, setText } from "./setup_parts.js";
import { _ } from "./words.js";

const GROUPS = () => ({ speeds: _("Speeds and pulses"), axes: _("Axes"), inputs: _("Inputs"), outputs: _("Outputs"), port: _("Bits of the parallel port") });
// What a field is: [its name, what it does].
const FIELDS = () => ({
  interval: [_("Pulse interval, µs"), _("Time from pulse to pulse, 1 to 250 000 µs: it makes the fastest speed")],
  default_mm_min: [_("Default speed, mm/min"), _("Speed until a program gives another")],
  default_steps_per_s: [_("Default speed, steps/s"), _("Speed until a program gives another")],
  default_half_period_us: [_("Default half period, µs"), _("Half the time of a step, until a program gives another speed")],
  step_inverted: [_("STEP pulses inverted"), _("A pulse is low, for drivers that want it so")],
  timer: [_("Pulses by the timer"), _("Then STEP, DIR and tool need not be on neighbouring pins; without its tick the chip's PIO makes the pulses, to the tick")],
  used: [_("In use"), _("Without its tick the machine has no such axis")],
  steps_mm: [_("Steps/mm"), _("Steps of the motor for a millimetre; 1 through it is the length of a step")],
  steps_degree: [_("Steps per degree"), _("Steps of the motor for a degree")],
  max_mm_min: [_("Highest speed, mm/min"), _("No move of this axis is faster")],
  step: [_("STEP pin"), _("The chip's pin that makes the pulses")],
  dir: [_("DIR pin"), _("The chip's pin that gives the direction")],
  ...Object.fromEntries([1, 2, 3, 4, 5, 6].map((number) => [`pin_${number}`, [_("Pin {number}", { number }), _("A pin of this motor's coils, in the drive's order")]])),
  reversed: [_("Direction inverted"), _("The axis moves the other way")],
  pin: [_("Pin"), _("The chip's pin that has this function; —: the machine has it not")],
  bit: [_("Bit"), _("Bit of the port that shows this; —: none")],
  inverted: [_("Inverted"), _("Active, or on, when the line is low")],
});
const SIGNALS = () => ({ drives: _("Drives"), z_step: _("Pulse Z"), z_dir: _("Direction Z"), y_step: _("Pulse Y"), y_dir: _("Direction Y"), x_step: _("Pulse X"), x_dir: _("Direction X"), tool: _("Tool") });
const NONE = "-";

function help(control, text) {
  control.title = control.dataset.help = text;
  return control;
}

function left(cell) {
  cell.style.textAlign = "left";
  return cell;
}

class Board {
  // page: { order(name, fields), ask(text), say(text) }
  constructor(page) {
    this.page = page;
    this.now = null;  // what the panel has told of the chosen machine
    this.list = document.getElementById("machines");
    this.list.addEventListener("change", () => this.get());
    this.card = make("details", { id: "card-board", "data-can": "board", "data-as-is": "", ontoggle: () => { if (this.card.open) this.get(); } });
    Object.assign(this.card.style, { margin: "0 -.2rem", padding: "0 .2rem" });  // as far as its rows of buttons reach
    document.getElementById("machine-row").after(this.card);
    this.speak();
  }

  // All of it, in the language of now.
  speak() {
    const as = this.as ? this.as.value : "";
    this.as = help(make("input", { id: "board-as", value: as, maxLength: 32, pattern: "\\w+", required: true, autocomplete: "off", spellcheck: false }), _("Name of the new machine: letters, digits and _"));
    this.make = this.button("board-new", _("Make it"), _("Writes a board file on this PC that is like the chosen machine"));
    this.made = make("form", { className: "row fill", onsubmit: (event) => { event.preventDefault(); this.begin(); } },
      make("label", { className: "grow" }, make("span", {}), this.as), this.make);
    this.make.type = "submit";
    this.form = make("form", { id: "board-form", onsubmit: (event) => { event.preventDefault(); this.save(); } });
    this.card.replaceChildren(help(make("summary", { textContent: _("Make and change machines") }), _("Its speeds, axes, pins and their functions, in a board file on this PC")),
      this.made, this.form);
    this.show();
  }

  button(id, text, title, onclick = null, className = "") {
    return help(Object.assign(button(text, onclick, className), { id }), title);
  }

  async get() {
    if (this.list.value) await this.order("get");
  }

  // An order about the chosen machine; true if it was carried out.
  async order(what, fields = {}, told = "") {
    const answer = await this.page.order("board", { what, name: this.list.value, language: document.documentElement.lang, ...fields });
    if (answer.error) return false;
    if (answer.t === "board") {
      this.now = answer;
      this.show();
    }
    if (told) this.page.say(told);
    return true;
  }

  async begin() {
    if (!(await this.order("new", { as: this.as.value }))) return;
    const { name } = this.now;
    if (![...this.list.options].some(({ value }) => value === name)) this.list.append(new Option(name, name));
    this.list.value = name;
    this.as.value = "";
    this.show();
    this.page.say(_("{name} is made: change it below.", { name }));
  }

  async save() {
    const values = this.changed();
    if (!Object.keys(values).length) return this.page.say(_("Nothing is changed."));
    return this.order("set", { values }, this.later());
  }

  later() { return _("Saved. The board takes it when it is restarted as {name}; home it then.", { name: this.list.value }); }

  async remove() {
    const name = this.list.value;
    if (!(await this.page.ask(_("Delete {name}? Its text stays beside it, in {name}.old.", { name }))) || !(await this.order("remove"))) return;
    this.list.options[this.list.selectedIndex].remove();
    await this.get();
    this.page.say(_("{name} is deleted.", { name }));
  }

  // Fields that differ from the file: {key: text, true or false}.
  changed() {
    const values = {};
    for (const control of this.form.elements) {
      const { key, before } = control.dataset, now = control.type === "checkbox" ? control.checked : control.value;
      if (key && String(now) !== before) values[key] = now;
    }
    for (const row of this.form.querySelectorAll("[data-new]")) {
      const [name, pin] = row.querySelectorAll("input, select");
      if (name.value.trim() && pin.value !== NONE) values[`${row.dataset.new}.${name.value.trim()}.pin`] = pin.value;
    }
    return values;
  }

  show() {
    const name = this.list.value, { groups = [], own = true, old = false, name: told = "" } = this.now || {};
    setText(this.made.querySelector("span"), _("New machine, like {name}", { name }));
    if (told !== name) return this.form.replaceChildren();
    if (!own) return this.form.replaceChildren(note(_("{name} is one of Passo's own, and stays as it is: make a machine that is like it.", { name })));
    const undo = this.button("board-back", _("Take the last change back"), _("The file becomes what it was before; once more brings the change again"), () => this.order("back", {}, this.later()));
    undo.hidden = !old;
    const save = this.button("board-save", _("Save the machine"), _("The firmware's check looks at it first; the old file is kept"), null, "go");
    save.type = "submit";
    const row = make("p", { className: "row fill" }, save, undo, this.button("board-remove", _("Delete the machine"), _("Asks, then takes it out of the list; the board keeps what it has"), () => this.remove(), "danger"));
    for (const each of [this.make, ...row.children]) each.dataset.stands = "";
    return this.form.replaceChildren(...groups.map((group) => this.group(group)), row);
  }

  group({ what, rows, names = [], new: added = "" }) {
    const words = FIELDS(), box = make("div", {}, make("h3", { textContent: GROUPS()[what] }));
    if (what === "speeds" || what === "axes") {
      box.append(...rows.map(({ name, fields }) => make("fieldset", {}, make("legend", { textContent: name }),
        make("div", { className: "pairs" }, ...fields.filter(({ kind }) => kind !== "box").map((field) => this.labelled(field, words, name))),
        make("p", { className: "row" }, ...fields.filter(({ kind }) => kind === "box").map((field) => this.labelled(field, words, name))))));
      return box;
    }
    const body = make("tbody", {}, ...rows.map(({ name, what: signal, fields }) => {
      const shown = name || SIGNALS()[signal];
      return make("tr", {}, left(make("th", { scope: "row", textContent: shown })), ...fields.map((field) => make("td", {}, this.control(field, words, shown))));
    }));
    const heads = [_("Function"), words[what === "port" ? "bit" : "pin"][0], words.inverted[0]];
    if (added) body.append(this.another(added, names, words));
    box.append(make("table", {}, make("thead", {}, make("tr", {}, ...heads.map((textContent, n) => (n ? (node) => node : left)(make("th", { scope: "col", textContent }))))), body));
    return box;
  }

  // A row for a function that the machine has not yet.
  another(section, names, words) {
    const list = make("datalist", { id: `board-${section}` }, ...names.map((value) => make("option", { value })));
    const name = help(make("input", { maxLength: 16, size: 8, pattern: "[\\w+\\-]+", placeholder: _("one more"), "aria-label": _("Function of one more pin"), autocomplete: "off", spellcheck: false }), _("Name of a function, as the documents have it; then its pin"));
    name.setAttribute("list", list.id);
    return make("tr", { "data-new": section }, left(make("td", {}, name, list)), make("td", {}, this.control({ kind: "pin", what: "pin", value: NONE, lacks: true }, words, _("one more"))), make("td", {}));
  }

  labelled(field, words, name) {
    const text = make("span", { textContent: words[field.what][0] }), control = this.control(field, words, name);
    return field.kind === "box" ? make("label", { className: "check" }, control, text) : make("label", {}, text, control);
  }

  control({ key = "", kind, what, value, lacks = false }, words, name) {
    const [label, sentence] = words[what], { pins = [] } = this.now;
    const values = kind === "bit" ? [..."76543210"] : kind === "pin" ? (pins.includes(value) || value === NONE ? pins : [...pins, value]).map(String) : null;
    const made = values ? make("select", {}, ...(lacks ? [new Option("—", NONE)] : []), ...values.map((each) => new Option(each, each)))
      : kind === "box" ? make("input", { type: "checkbox", checked: value }) : make("input", { type: "number", step: "any", inputMode: "decimal", required: true });
    if (kind !== "box") made.value = String(value);
    if (key) Object.assign(made.dataset, { key, before: String(value) });
    made.setAttribute("aria-label", name ? `${name}: ${label}` : label);
    return help(made, sentence);
  }
}

window.PassoBoard = Board;
