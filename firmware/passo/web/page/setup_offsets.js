// Work offsets: named, chosen, zeroed, gone to.

import { button, make, note, setText, store, stored } from "./setup_parts.js";
import { words } from "./setup_lines.js";
import { _ } from "./words.js";

const SYSTEMS = ["G54", "G55", "G56", "G57", "G58", "G59"];

export class Offsets {
  constructor(setup) {
    this.setup = setup;
    this.names = stored("offset-names", {});
    this.rows = SYSTEMS.map((system) => this.row(system));
    this.reason = make("p", { className: "reason", role: "status" });
    this.zeros = make("p", { className: "row fill zeros" });
    this.go = button(_("Go to zero: up, X and Y"), () => this.goTo());
    this.down = button(_("Then down to Z 0"), () => this.goDown());
    this.go.id = "offset-go";
    this.down.id = "offset-down";
    this.node = make("div", {}, make("div", { className: "offsets" }, ...this.rows.map(({ node }) => node)), this.reason,
      make("h3", { textContent: _("Zero of the one chosen, here") }), this.zeros, make("p", { className: "row fill" }, this.go, this.down),
      note(_("The board keeps the places, this browser the names. G54 to G59 are chosen by programs, too.")));
    this.axes = "";
  }

  row(system) {
    const choose = button(system, () => this.setup.run([{ line: () => system, text: system }]), "system");
    const name = make("input", { value: this.names[system] || "", maxLength: 16, "aria-label": _("Name of {system}", { system }), placeholder: _("name") });
    name.onchange = () => { this.names[system] = name.value; store("offset-names", this.names); };
    const place = make("span", { className: "at" });
    return { system, choose, place, node: make("div", { className: "offset" }, choose, name, place) };
  }

  show() {
    const { facts, page } = this.setup, axes = page.axes(), why = this.setup.why(false);
    if (axes !== this.axes) {
      this.axes = axes;
      this.zeros.replaceChildren(...[...Array.from(axes), axes].map((which) => button(which.length > 1 ? _("All axes") : `${which.toUpperCase()} = 0`, () => this.zero(which))));
    }
    for (const { system, choose, place } of this.rows) {
      const at = facts && facts.systems[system];
      setText(place, at ? at.map((value, n) => `${axes[n] ? axes[n].toUpperCase() : ""} ${value.toFixed(2)}`).join("  ") : "");
      choose.setAttribute("aria-pressed", String(Boolean(facts) && facts.active === system));
      choose.disabled = Boolean(why);
    }
    for (const each of this.zeros.children) each.disabled = Boolean(why);
    this.go.disabled = Boolean(why || this.setup.unhomed());
    this.down.disabled = Boolean(why || this.setup.unhomed());
    setText(this.reason, why || this.setup.unhomed());
  }

  async zero(axes) {
    const { page } = this.setup, system = this.setup.facts ? this.setup.facts.active : "";
    if (!(await page.ask(_("Set the zero of {axes} in {system} here?", { axes: axes.toUpperCase(), system })))) return;
    const place = {};
    for (const axis of axes) place[axis] = 0;
    this.setup.run([{ line: () => `G10L20P0${words(place)}`, text: "" }]);
  }

  async goTo() {
    const { page } = this.setup;
    if (!(await page.ask(_("Z goes to its top, then X and Y to zero. Is the way free?")))) return;
    this.setup.run([{ line: () => `G21G90G53G0Z${this.setup.top().toFixed(3)}`, text: "" }, { line: () => "G21G90G0X0Y0", text: "" }]);
  }

  async goDown() {
    if (await this.setup.page.ask(_("The tool goes down to zero of Z, slowly. Is the way free?"))) this.setup.run([{ line: () => "G21G90G1Z0F300", text: "" }]);
  }

  close() {}
}
