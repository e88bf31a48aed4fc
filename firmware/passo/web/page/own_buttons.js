// Buttons of one's own: lines of G-code under a name. They stay in this browser, and the page says so.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const MOST = 24, MOST_LINES = 40;

function kept() {
  try { return JSON.parse(localStorage.getItem("buttons")) || []; } catch (error) { return []; }
}

export class OwnButtons {
  // order(name, fields): a promise of the answer; ask(text): of a yes; rest(): a promise, once the machine is at rest;
  // stops(): how often STOP was pressed.
  constructor(order, ask, rest, stops) {
    Object.assign(this, { order, ask, rest, stops });
    this.made = kept();
    this.runs = false;
    $("own-form").onsubmit = (event) => { event.preventDefault(); this.keep($("own-name").value.trim(), $("own-lines").value); };
    this.show();
  }

  store() {
    try { localStorage.setItem("buttons", JSON.stringify(this.made)); } catch (error) { /* until the page is closed */ }
    this.show();
  }

  keep(name, text) {
    const lines = text.split("\n").map((line) => line.trim()).filter(Boolean).slice(0, MOST_LINES);
    if (!name) return;
    this.made = this.made.filter((each) => each.name !== name);
    if (lines.length) this.made = this.made.concat({ name, lines }).slice(-MOST);
    $("own-form").reset();
    this.store();
  }

  // Line after line: each is answered, and what it moves has ended, before the next goes.
  async run(own) {
    if (this.runs) return;
    this.runs = true;
    const stops = this.stops();
    for (const line of own.lines) {
      if ((await this.order("line", { line })).error || !(await this.rest()) || this.stops() !== stops) break;
    }
    this.runs = false;
  }

  button(own) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = own.name;
    made.title = own.lines.join("\n");
    made.onclick = () => this.run(own);
    return made;
  }

  change(own) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = _("Change {name}", { name: own.name });
    made.onclick = () => {
      $("own-name").value = own.name;
      $("own-lines").value = own.lines.join("\n");
      $("own-name").focus();
    };
    return made;
  }

  show() {
    $("own-buttons").replaceChildren(...this.made.map((own) => this.button(own)));
    $("own-changes").replaceChildren(...this.made.map((own) => this.change(own)));
  }
}
