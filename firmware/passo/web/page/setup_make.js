// Surfacing and the height map: computed by the PC's panel or in the tab, never here. A board has not this script.

import { Fields, button, make, note, setText } from "./setup_parts.js";
import { _ } from "./words.js";

const mm = (name, label, value, min, max) => ({ name, label, value, min, max });
const POLL_MS = 700;
const why = () => ({ relative: _("relative moves (G91)"), cycle: _("a cycle, a probe or another offset"), plane: _("an arc outside of the XY plane"), place: _("a cut from a place that is not known"),
  arc: _("an arc without a centre"), length: _("a line that is not understood, or too many") });

class Surfacing {
  constructor(setup) {
    this.setup = setup;
    this.fields = new Fields("surface", [mm("x", _("Length in X, mm"), 100, 1, 5000), mm("y", _("Length in Y, mm"), 80, 1, 5000), mm("tool", _("Diameter of the tool, mm"), 20, 0.1, 200),
      mm("overlap", _("Overlap of rows, %"), 40, 0, 90), mm("depth", _("Depth, mm"), 0.5, 0.01, 100), mm("cut", _("At most per level, mm"), 0.5, 0.01, 100), mm("feed", _("Feed, mm/min"), 1500, 1, 100000),
      mm("plunge", _("Down, mm/min"), 300, 1, 100000), mm("rpm", _("Speed of the tool, rpm"), 12000, 0, 100000), mm("safe", _("Free height, mm"), 5, 0.5, 200)], () => {});
    this.reason = make("p", { className: "reason", role: "status" });
    this.go = button(_("Make the program and show it"), () => this.make(), "go whole");
    this.go.id = "surface-make";
    this.node = make("div", {}, note(_("Zero of X and Y at the front left corner of the area, zero of Z on top. The tool goes down beside the work. The program becomes a job: look at it, then run it.")),
      this.fields.node, this.reason, make("p", { className: "row fill" }, this.go));
  }

  async make() {
    const answer = await this.setup.page.order("make", { what: "surface", ...this.fields.values() });
    if (!answer.error) this.setup.page.chosen(answer.name);
  }

  show() {
    const reason = this.fields.wrong() || this.setup.why(false);
    setText(this.reason, reason);
    this.go.disabled = Boolean(reason);
  }

  close() {}
}

class HeightMap {
  constructor(setup) {
    this.setup = setup;
    this.known = null;
    this.asked = 0;
    this.fields = new Fields("map", [mm("x0", _("From X, mm"), 0, -5000, 5000), mm("x1", _("To X, mm"), 100, -5000, 5000), mm("y0", _("From Y, mm"), 0, -5000, 5000), mm("y1", _("To Y, mm"), 80, -5000, 5000),
      mm("columns", _("Points in X"), 5, 2, 50), mm("rows", _("Points in Y"), 4, 2, 50), mm("safe", _("Free height, mm"), 3, 0.5, 100), mm("deep", _("Deepest, mm below zero"), 3, 0.1, 100), mm("feed", _("Touch, mm/min"), 100, 1, 2000)], () => {});
    this.reason = make("p", { className: "reason", role: "status" });
    this.picture = make("div", { className: "heights" });
    this.told = make("p", { role: "status" });
    this.go = button(_("Touch the points"), () => this.probe(), "go whole");
    this.jobs = make("select", { "aria-label": _("Job that follows the map") });
    this.level = button(_("Make the job follow the map"), () => this.follow());
    this.drop = button(_("Forget the map"), () => this.dropMap(), "danger");
    Object.assign(this.go, { id: "map-probe" });
    Object.assign(this.level, { id: "map-level" });
    this.node = make("div", {}, note(_("Set zero of the work first, Z by a touch. The map says how much higher or lower the work lies at each point than there. It stays as long as the panel runs; with another tool set zero of Z at the same place.")),
      this.fields.node, this.reason, make("p", { className: "row fill" }, this.go), this.picture, this.told, make("p", { className: "row fill" }, make("label", { className: "grow" }, make("span", { textContent: _("Job") }), this.jobs), this.level, this.drop));
    this.get();
  }

  async probe() {
    if (!(await this.setup.page.ask(_("The tool goes over all points and touches the work at each. Is the way free, and the probe on the tool?")))) return;
    const values = this.fields.values();
    if (values && !(await this.setup.page.order("map", { what: "probe", ...values })).error) this.get();
  }

  async get() {
    this.asked = Date.now();
    this.known = await this.setup.page.send("map", { what: "get" });
    this.draw();
  }

  async dropMap() {
    if (!(await this.setup.page.order("map", { what: "drop" })).error) this.get();
  }

  async follow() {
    const answer = await this.setup.page.order("map", { what: "level", name: this.jobs.value });
    if (answer.error) return;
    if (answer.why) this.setup.page.say(_("Line {line} cannot follow a map: {why}.", { line: answer.line, why: why()[answer.why] }));
    else this.setup.page.chosen(answer.name);
  }

  // Cells in the colours of their heights, with figures: Y upward.
  draw() {
    const { heights, columns, rows, whole } = this.known;
    if (!heights || !heights.length) {
      this.picture.replaceChildren();
      setText(this.told, _("There is no map yet."));
      return;
    }
    const low = Math.min(...heights), high = Math.max(...heights), cells = [];
    for (let row = rows - 1; row >= 0; row--) {
      for (let column = 0; column < columns; column++) {
        const height = heights[row * columns + (row % 2 ? columns - 1 - column : column)], cell = make("span", { textContent: height === undefined ? "" : height.toFixed(2) });
        if (height !== undefined) cell.dataset.level = high > low ? Math.round(4 * (height - low) / (high - low)) : 2;
        cells.push(cell);
      }
    }
    this.picture.className = `heights of-${Math.min(columns, 13)}`;
    this.picture.style.setProperty("grid-template-columns", `repeat(${columns}, 1fr)`);
    this.picture.replaceChildren(...cells);
    setText(this.told, whole ? _("Lowest {low}, highest {high} mm.", { low: low.toFixed(3), high: high.toFixed(3) }) : _("{count} of {all} points", { count: heights.length, all: rows * columns }));
  }

  show(report) {
    const reason = this.fields.wrong() || this.setup.why(true), known = this.known || {};
    setText(this.reason, reason);
    this.go.disabled = Boolean(reason);
    this.level.disabled = !known.whole || !this.jobs.value || Boolean(this.setup.why(false));
    this.drop.disabled = !known.heights || Boolean(this.setup.why(false));
    const names = this.setup.page.jobs();
    if (names.join() !== Array.from(this.jobs.options).map(({ value }) => value).join()) {
      const before = this.jobs.value;
      this.jobs.replaceChildren(...names.map((name) => new Option(name, name)));
      if (names.includes(before)) this.jobs.value = before;
    }
    if (known.heights && !known.whole && ["Run", "Idle"].includes(report.state) && Date.now() - this.asked > POLL_MS && this.setup.why(false) || this.ended(report)) this.get();
  }

  // True once: its job has come to its end since the last look.
  ended(report) {
    const how = report.job ? report.job.name + report.job.how : "", other = how !== this.how;
    this.how = how;
    return other && how === "height mapdone";
  }

  close() {}
}

window.PassoMake = { Surfacing, HeightMap };
