// Which parts of the page are seen: one at a time on a phone, all of them in two columns on a tablet, in three on a wide screen.

const COLUMNS = {
  1: [["move", "job", "overrides", "path", "setup", "machine"], [], []],
  2: [["move", "job"], ["path", "overrides", "setup", "machine"], []],
  3: [["move"], ["path", "job"], ["overrides", "setup", "machine"]],
};
const TWO = matchMedia("(min-width: 44rem)"), THREE = matchMedia("(min-width: 72rem)");

const tabs = () => Array.from(document.querySelectorAll("[data-tab]"));
const pane = (name) => document.getElementById(`pane-${name}`);

function used(name) { return Array.from(pane(name).children).some((card) => !card.hidden); }

export class Tabs {
  // changed(): other parts are seen, or at another width.
  constructor(changed) {
    this.changed = changed;
    this.chosen = "move";
    for (const tab of tabs()) tab.onclick = () => this.choose(tab.dataset.tab);
    for (const width of [TWO, THREE]) width.onchange = () => this.place();
    window.addEventListener("resize", () => this.place());
    this.place();
  }

  choose(name) {
    this.chosen = name;
    this.show();
    window.scrollTo(0, 0);
  }

  // Panes into the columns that the window has room for.
  place() {
    const count = THREE.matches ? 3 : TWO.matches ? 2 : 1;
    if (count !== this.count) {
      this.count = count;
      document.querySelectorAll(".column").forEach((column, n) => COLUMNS[count][n].forEach((name) => column.append(pane(name))));
    }
    this.show();
  }

  // A part without cards has no tab; where all are seen at once, the machine's cards make room for a part of the set-up that is open; a column without any gives its room to the others.
  show() {
    const there = tabs().filter((tab) => used(tab.dataset.tab)).map((tab) => tab.dataset.tab);
    if (!there.includes(this.chosen)) this.chosen = there[0] || "move";
    for (const tab of tabs()) {
      const name = tab.dataset.tab, shown = there.includes(name) && !(name === "machine" && this.count > 1 && document.body.dataset.setup);
      tab.hidden = !shown;
      tab.setAttribute("aria-current", String(name === this.chosen));
      pane(name).hidden = !shown || this.count === 1 && name !== this.chosen;
    }
    pane("overrides").hidden = !used("overrides") || pane("job").hidden;
    for (const column of document.querySelectorAll(".column")) column.hidden = !Array.from(column.children).some((each) => !each.hidden);
    document.querySelector("main").dataset.columns = document.querySelectorAll(".column:not([hidden])").length;
    this.changed();
  }
}
