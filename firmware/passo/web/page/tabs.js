// Which parts of the page are seen: one at a time on a phone, all of them in two columns on a tablet, in three on a wide screen.

const COLUMNS = {
  1: [["move", "job", "overrides", "path", "setup", "machine", "more", "who"], [], []],
  2: [["move", "setup", "machine", "more"], ["path", "job", "overrides", "who"], []],
  3: [["move"], ["path", "overrides", "setup", "machine"], ["job", "more", "who"]],
  "3 open": [["move"], ["path", "setup", "machine"], ["job", "overrides", "more", "who"]],  // with a part of the set-up open
  "2 plain": [["move", "path"], ["job", "overrides", "setup", "machine", "more", "who"], []],  // of a machine without a set-up, which has less to show
  "3 plain": [["move"], ["path", "overrides", "setup", "machine", "more", "who"], ["job"]],
};
const BESIDE = { job: ["overrides"], machine: ["more", "who"] };  // part: what is seen with it, in another column
const TWO = matchMedia("(min-width: 44rem)"), THREE = matchMedia("(min-width: 72rem)");

const tabs = () => Array.from(document.querySelectorAll("[data-tab]"));
const pane = (name) => document.getElementById(`pane-${name}`);
const partsOf = (name) => [name, ...(BESIDE[name] || [])].filter(used);

function used(name) { return Array.from(pane(name).children).some((card) => !card.hidden); }

export class Tabs {
  // changed(): other parts are seen, or at another width.
  constructor(changed) {
    this.changed = changed;
    this.chosen = "move";
    for (const tab of tabs()) tab.onclick = () => this.choose(tab.dataset.tab);
    for (const width of [TWO, THREE]) width.onchange = () => this.show();
    window.addEventListener("resize", () => this.show());
    this.show();
  }

  choose(name) {
    this.chosen = name;
    this.show();
    window.scrollTo(0, 0);
  }

  // Panes into the columns that the window has room for.
  place() {
    this.count = THREE.matches ? 3 : TWO.matches ? 2 : 1;
    const kind = this.count > 1 && !used("setup") ? `${this.count} plain` : this.count === 3 && document.body.dataset.setup ? "3 open" : this.count;
    if (kind === this.kind) return;
    this.kind = kind;
    document.querySelectorAll(".column").forEach((column, n) => COLUMNS[kind][n].forEach((name) => column.append(pane(name))));
  }

  // A part of one folded card is open on a phone: a tab that shows a title alone wants a second tap. Where all parts are seen at once it is as it was.
  unfold() {
    for (const fold of document.querySelectorAll(".pane > section > details")) {
      const alone = this.count === 1 && !fold.closest("[hidden]") && document.querySelectorAll(".pane:not([hidden]) > section:not([hidden])").length === 1;
      if (alone === (fold.dataset.alone === "true")) continue;
      fold.dataset.alone = alone;
      fold.open = alone;
    }
  }

  // A part without cards has no tab; where all are seen at once, the machine's cards make room for a part of the set-up that is open; a column without any gives its room to the others.
  show() {
    this.place();
    const there = tabs().map((tab) => tab.dataset.tab).filter((name) => partsOf(name).length);
    if (!there.includes(this.chosen)) this.chosen = there[0] || "move";
    for (const tab of tabs()) {
      const name = tab.dataset.tab, shown = there.includes(name) && !(name === "machine" && this.count > 1 && document.body.dataset.setup);
      tab.hidden = !shown;
      tab.setAttribute("aria-current", String(name === this.chosen));
      for (const each of [name, ...(BESIDE[name] || [])]) pane(each).hidden = !used(each) || !shown || this.count === 1 && name !== this.chosen;
    }
    this.unfold();
    for (const column of document.querySelectorAll(".column")) column.hidden = !Array.from(column.children).some((each) => !each.hidden);
    document.querySelector("main").dataset.overrides = used("overrides");
    document.querySelector("main").dataset.columns = document.querySelectorAll(".column:not([hidden])").length;
    this.changed();
  }
}
