// The board proves itself: this part of the last card begins `passo prove` beside the panel, and shows its rows. Only a PC can: no board has this script.

import { button, make, note, setText } from "./setup_parts.js";
import { _ } from "./words.js";

const WORDS = () => ({ better: _("better"), "as promised": _("as promised"), worse: _("worse"), "left out": _("left out") });

class Prove {
  // page: { order(name, fields), ask(text) }
  constructor(page) {
    this.page = page;
    this.now = { how: "" };
    this.card = make("details", { id: "card-prove", "data-can": "prove", "data-as-is": "" });
    (document.getElementById("card-board") || document.getElementById("machine-row")).after(this.card);  // a card of its own would make the page longer than two screens
    this.speak();
  }

  // All of it, in the language of now. Rows keep that in which they were measured.
  speak() {
    const pins = Boolean(this.pins && this.pins.checked);
    this.pins = make("input", { type: "checkbox", id: "prove-pins", checked: pins });
    this.begin = button(_("Let it prove itself"), () => this.start(), "go");
    this.begin.id = "prove";
    this.end = button(_("End it"), () => this.page.order("prove", { what: "end" }), "danger");
    this.copy = button(_("Copy the report"), () => this.give());
    this.bar = make("progress", { max: 1, value: 0, "aria-label": _("Progress of the proof") });
    this.line = make("p", { role: "status", id: "prove-told" });
    this.sentences = make("div", {});
    this.rows = make("tbody", { id: "prove-rows" });
    this.table = make("table", {}, make("thead", {}, make("tr", {}, ...[_("Measured"), _("Found")].map((textContent) => make("th", { scope: "col", textContent })))), this.rows);
    this.card.replaceChildren(make("summary", { textContent: _("Prove the board") }),
      note(_("In some two minutes the chip measures itself: clock, flash, memory, link, edges on its pins, emergency input, watchdog. The motors' current stays off. Nothing is changed, and the board starts anew: home it again.")),
      make("label", { className: "check" }, this.pins, make("span", { textContent: _("The drivers are unplugged, or their enable is wired: STEP and DIR may move") })),
      make("p", { className: "row fill" }, this.begin, this.end, this.copy), this.bar, this.line, this.sentences, this.table);
    this.show();
  }

  async start() {
    if (!(await this.page.ask(_("The board leaves its work, and starts anew afterwards. Begin?")))) return;
    await this.page.order("prove", { what: "begin", pins: this.pins.checked, language: document.documentElement.lang });
  }

  // What the panel says of it.
  told(message) {
    this.now = message;
    this.show();
  }

  show() {
    const { how, rows = [], part = "", number = 0, of = 1, said = "", header = "", summary = [], report = "" } = this.now, runs = how === "runs";
    this.begin.hidden = runs;
    this.pins.disabled = runs;
    this.end.hidden = this.bar.hidden = !runs;
    this.copy.hidden = !report;
    this.bar.max = of;
    this.bar.value = number;
    setText(this.line, { "": "", runs: said || (part ? `${header}: ${part}…` : _("The board is asked to leave its work…")), done: header, ended: _("Ended before all was measured."), failed: said || _("It ended without a report.") }[how]);
    const worse = rows.filter(({ verdict }) => verdict === "worse");
    this.sentences.replaceChildren(...worse.map((row) => make("p", { className: "wrong", textContent: `${row.what}: ${row.found}. ${row.advice}.` })),
      ...summary.slice(worse.length).map((textContent) => make("p", { textContent })));
    this.table.hidden = !rows.length;
    if (rows.length < this.rows.children.length) this.rows.replaceChildren();
    this.rows.append(...rows.slice(this.rows.children.length).map((row) => this.row(row)));
  }

  row({ what, found, promised, verdict }) {
    const word = WORDS()[verdict], judged = word && make("small", { textContent: promised ? `${word} (${promised})` : word });
    return make("tr", {}, make("th", { scope: "row", textContent: what }), make("td", { className: verdict === "worse" ? "wrong" : "" }, found, ...(word ? [make("br", {}), judged] : [])));
  }

  // The report's text, to be pasted into an issue. Only a page of this PC may use the clipboard unasked; elsewhere the text is chosen and copied.
  async give() {
    const text = this.now.report;
    try {
      await navigator.clipboard.writeText(text);
    } catch (error) {
      const area = make("textarea", { value: text });
      this.card.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    setText(this.line, _("The report is copied: paste it into an issue."));
  }
}

window.PassoProve = Prove;
