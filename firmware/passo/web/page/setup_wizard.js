// A wizard on the page: where to stand, the picture, what is asked, why it may not begin, and how far it is.

import { Fields, button, make, note, setText } from "./setup_parts.js";
import { Scene } from "./setup_scene.js";
import { dry } from "./setup_wizards.js";
import { _ } from "./words.js";

const LIFT = 20, LEAST_LIFT = 1, TRAVEL = 800;  // mm, mm/min

export class Wizard {
  // setup: { page, lines, why(probing), low(), room(), facts }; key and spec: of setup_wizards.js
  constructor(setup, key, spec) {
    Object.assign(this, { setup, spec });
    this.seen = false;  // the probe has been seen closed, and open again
    this.closed = false;
    this.told = "";
    this.scene = new Scene(spec.title);
    this.fields = new Fields(key, spec.fields, () => this.drawn());
    this.probe = make("p", { className: "lamp" });
    this.reason = make("p", { className: "reason", role: "status" });
    this.progress = make("p", { className: "progress", role: "status" });
    this.start = button(_("Start"), () => this.begin(), "go whole");
    this.start.id = `wizard-${key}`;
    this.show_ = button(_("Show it"), () => this.scene.play());
    this.dry = button(_("Dry run in the air"), () => this.dryRun());
    const rows = make("details", {}, make("summary", { textContent: _("Speeds") }), this.fields.more);
    this.node = make("div", {}, note(spec.stand), this.scene.node, make("p", { className: "row fill" }, this.show_, this.dry), this.fields.node, rows, this.probe, this.reason, this.progress,
      make("p", { className: "row fill" }, this.start));
    this.drawn();
  }

  steps(p) { return this.spec.steps(p, this.setup.low()); }

  drawn() {
    const p = this.fields.values();
    if (!p) return;
    this.scene.draw(this.spec.shapes(p), this.spec.start(p), this.steps(p), this.spec.tool(p));
  }

  // How far a dry run can go up, mm.
  lift() { return Math.min(LIFT, Math.floor(10 * this.setup.room()) / 10); }

  show(report) {
    const { lines } = this.setup, closed = (report.pins || "").includes("P");
    this.seen = this.seen || this.closed && !closed;
    this.closed = closed;
    const why = this.fields.wrong() || this.setup.why(true);
    setText(this.probe, closed ? _("Probe: closed") : this.seen ? _("Probe: open, and seen closed") : _("Probe: open. Touch the tool with the plate once: it is to close."));
    this.probe.dataset.lamp = closed ? "closed" : this.seen ? "seen" : "";
    setText(this.reason, lines.runs ? "" : why);
    this.start.disabled = Boolean(why);
    this.dry.disabled = Boolean(this.fields.wrong() || this.setup.why(false)) || this.lift() < LEAST_LIFT;
    for (const node of [this.fields.node, this.fields.more]) node.classList.toggle("busy", lines.runs);
    setText(this.progress, this.told);
    this.progress.hidden = !this.told;
  }

  async begin() {
    if (!this.seen && !(await this.setup.page.ask(_("The probe has not been seen to close yet. If it does not, the tool goes on into the work. Start all the same?")))) return;
    const p = this.fields.values();
    if (p) await this.run(this.steps(p), _("Done."));
  }

  async dryRun() {
    const p = this.fields.values(), lift = this.lift();
    if (p && (await this.setup.page.ask(_("The tool goes up {lift} mm and makes the moves there, without going down. Is the way free?", { lift })))) {
      await this.run(dry(this.steps(p), lift, p.travel || TRAVEL), _("The dry run has ended."), true);
    }
  }

  async run(steps, done, isDry = false) {
    this.scene.end();
    const why = await this.setup.run(steps, (n) => {
      this.told = _("Step {n} of {all}: {what}", { n: n + 1, all: steps.length, what: steps[n].text });
      if (!isDry) this.scene.mark(n);
      this.setup.show();
    });
    if (!why && !isDry) this.scene.mark(steps.length);
    this.told = why ? _("Ended: {why}", { why }) : done;
    this.setup.show();
  }

  close() { this.scene.end(); }
}
