// Buttons of one's own: lines of G-code under a name. They stay in this browser; a board that keeps jobs keeps buttons, too: as jobs whose
// names begin with PREFIX.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const MOST = 24, MOST_LINES = 40, PREFIX = "KEY-";

function kept() {
  try { return JSON.parse(localStorage.getItem("buttons")) || []; } catch (error) { return []; }
}

export class OwnButtons {
  // order(name, fields): a promise of the answer; ask(text): of a yes; rest(): a promise, once the machine is at rest;
  // stops(): a value that changes if any page presses STOP or jogs.
  constructor(order, ask, rest, stops) {
    Object.assign(this, { order, ask, rest, stops });
    this.made = kept();
    this.runs = false;
    $("own-form").onsubmit = (event) => { event.preventDefault(); this.set($("own-name").value.trim(), $("own-lines").value); };
    this.show();
  }

  store() {
    try { localStorage.setItem("buttons", JSON.stringify(this.made)); } catch (error) { /* until the page is closed */ }
    this.show();
  }

  set(name, text) {
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

  // Buttons that the board keeps; shelf: what keeps jobs there.
  onBoard(names, shelf) {
    this.shelf = names && shelf;
    const found = (names || []).filter((name) => name.startsWith(PREFIX));
    const text = found.join() + Boolean(names);
    if ($("own-board").dataset.shown === text) return;
    $("own-board").dataset.shown = text;
    $("own-board").replaceChildren(...found.map((name) => this.boardButton(name)));
    this.show();
  }

  boardButton(name) {
    const made = document.createElement("button"), gone = document.createElement("button"), pair = document.createElement("span");
    const shown = name.slice(PREFIX.length).replace(/_/g, " ");
    Object.assign(made, { type: "button", textContent: shown });
    Object.assign(gone, { type: "button", textContent: "×", className: "danger" });
    gone.setAttribute("aria-label", _("Remove {name} from the board?", { name: shown }));
    made.onclick = () => this.order("stored", { what: "run", name });
    gone.onclick = async () => {
      if (!(await this.ask(_("Remove {name} from the board?", { name: shown })))) return;
      await this.order("stored", { what: "delete", name });
      this.shelf.known = false;
    };
    pair.append(made, gone);
    return pair;
  }

  keepOnBoard(own) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = _("Keep {name} on the board", { name: own.name });
    made.onclick = () => this.shelf.keepText(PREFIX + own.name, own.lines.join("\n") + "\n");
    return made;
  }

  show() {
    $("own-buttons").replaceChildren(...this.made.map((own) => this.button(own)));
    $("own-changes").replaceChildren(...this.made.map((own) => this.change(own)), ...(this.shelf ? this.made.map((own) => this.keepOnBoard(own)) : []));
  }
}
