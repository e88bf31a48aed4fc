// The settings of the board: by group, found by words, saved to a file and taken back from it.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const MASKS = [2, 3, 23], HEADER = "; passo settings, version 2", SYSTEMS = ["G54", "G55", "G56", "G57", "G58", "G59"];
// A group is what lies below its first number, and above that of the one before.
const groups = () => [[10, _("Step pulses and inputs")], [20, _("Reports and accuracy")], [30, _("Limits and homing")], [100, _("Tool")], [110, _("Steps per mm")], [120, _("Highest speeds")],
  [130, _("Accelerations")], [140, _("Travel")], [1000, _("Smooth motion")]];

// What a value means, where it is no measure.
function sense(number, most, value, axes) {
  if (MASKS.includes(number)) return Array.from(axes).filter((axis, n) => Number(value) >> n & 1).join(" ").toUpperCase() || _("none");
  return Number(most) === 1 && number < 100 ? (Number(value) ? _("on") : _("off")) : "";
}

export class Settings {
  // page: { order(name, fields), ask(text), say(text), axes(), turns(): those that count degrees, rules(), lines(): what asks the board line by line, a promise; null: only settings are ordered }
  constructor(page) {
    this.page = page;
    this.values = {};
    $("settings-seek").oninput = () => this.seek();
    $("settings-save").onclick = () => this.save();
    $("settings-restore").onchange = async () => {
      const [file] = $("settings-restore").files;
      if (file) await this.restore(await file.text());
      $("settings-restore").value = "";
    };
  }

  show(values) {
    this.values = values;
    const numbers = Object.keys(values).map(Number).sort((a, b) => a - b), rows = [];
    let group = -1;
    const all = groups();
    for (const number of numbers) {
      const now = all.findIndex(([end]) => number < end);
      if (now !== group) rows.push(this.head(all[now][1]));
      group = now;
      rows.push(this.row(number));
    }
    $("settings").replaceChildren(...rows);
    this.seek();
  }

  head(name) {
    const row = document.createElement("tr");
    row.innerHTML = '<th scope="colgroup" colspan="5" class="group"></th>';
    row.firstChild.textContent = name;
    return row;
  }

  row(number) {
    const [name, unit, least, most] = this.page.rules()[number] || ["", "", "", ""];
    const turned = number > 99 && this.page.turns().includes("xyza"[number % 10]);
    const row = document.createElement("tr");
    row.innerHTML = `<th scope="row">$${number}</th><td></td><td><input type="number" step="any"><small></small></td><td></td><td></td>`;
    const [, meaning, , units, bounds] = row.children;
    meaning.textContent = name.replace(/^(?:[xyza]: )?(.*)$/, (whole, text) => whole.replace(text, turned && number < 110 ? _("steps per degree") : _(text)));
    units.textContent = (turned ? unit.replace("mm", "°") : unit).replace("steps", _("steps"));
    bounds.textContent = least === "" ? "" : `${least} … ${most}`;
    const input = row.querySelector("input");
    input.value = Number(this.values[number]);
    input.setAttribute("aria-label", `$${number} ${meaning.textContent}`);
    row.querySelector("small").textContent = sense(number, most, this.values[number], this.page.axes());
    input.onchange = async () => {
      if (await this.page.ask(_("Save {name} = {value}?", { name: `$${number}`, value: input.value }))) await this.page.order("set", { number, value: Number(input.value) });
      else input.value = Number(this.values[number]);
    };
    return row;
  }

  // Only rows that have all the words; a group without any is not shown.
  seek() {
    const wanted = $("settings-seek").value.toLowerCase().split(/\s+/).filter(Boolean);
    let head = null;
    for (const row of $("settings").children) {
      if (row.firstChild.className === "group") { head = row; head.hidden = true; continue; }
      const text = `${row.textContent} ${head ? head.textContent : ""}`.toLowerCase();
      row.hidden = !wanted.every((word) => text.includes(word));
      if (head && !row.hidden) head.hidden = false;
    }
  }

  // Lines that give the board back what it has now, as `passo settings backup` writes them; null: it did not answer.
  async lines() {
    const lines = await this.page.lines();
    const found = Object.keys(this.values).map(Number).sort((a, b) => a - b).map((number) => `$${number}=${this.values[number]}`);
    if (!lines) return found;
    const starts = await lines.say("$N"), places = await lines.say("$#");
    if (starts.error || places.error) return null;
    found.push(...starts.said.filter((text) => text.slice(0, 2) === "$N"));
    for (const text of places.said) {
      const [name, value] = text.slice(1, -1).split(":");
      if (SYSTEMS.includes(name)) found.push(`G10L2P${SYSTEMS.indexOf(name) + 1}${value.split(",").map((each, n) => "XYZA"[n] + each).join("")}`);
      else if (/^T\d+$/.test(name)) found.push(`G10L1P${name.slice(1)}Z${value}`);
    }
    return found;
  }

  async save() {
    const lines = await this.lines();
    if (!lines) return this.page.say(_("The board does not answer now: let it come to rest."));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([[HEADER, ...lines, ""].join("\n")], { type: "text/plain" }));
    link.download = `passo-${new Date().toISOString().slice(0, 10)}.txt`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    return null;
  }

  // Have one line of a back-up carried out.
  set(lines, line) {
    if (lines) return lines.say(line);
    const [, number, value] = /^\$(\d+)=([-.\d]+)$/.exec(line) || [];
    return number ? this.page.order("set", { number: Number(number), value: Number(value) }) : { error: 3 };
  }

  // Send what differs; what is refused is sent again behind the others, as long as that helps.
  async restore(text) {
    const [head, ...rest] = text.replace(/\r/g, "").split("\n").map((line) => line.trim()).filter(Boolean);
    if (head !== HEADER) return this.page.say(_("This is no back-up that the page reads. Older ones: passo settings restore."));
    const wrong = rest.find((line) => !/^(\$\d+=[-.\d]+|\$N\d=.*|G10L[12]P\d+[XYZA][-.\dXYZA]*)$/.test(line));
    if (wrong) return this.page.say(_("The back-up has a line that is no setting: {line}", { line: wrong }));
    const have = await this.lines();
    if (!have) return this.page.say(_("The board does not answer now: let it come to rest."));
    let left = rest.filter((line) => !have.includes(line)).sort((a, b) => a.startsWith("$13=") - b.startsWith("$13="));
    if (!left.length) return this.page.say(_("Nothing differs from the back-up."));
    if (!(await this.page.ask(_("{count} lines differ. Restore them? {lines}", { count: left.length, lines: left.slice(0, 6).join("  ") + (left.length > 6 ? " …" : "") })))) return null;
    const lines = await this.page.lines(), count = left.length;
    if (lines && left.some((line) => line.startsWith("G10"))) await lines.say(Number(this.values[13]) ? "G20" : "G21");
    for (let before = left.length + 1; left.length && left.length < before;) {
      before = left.length;
      const refused = [];
      for (const line of left) if ((await this.set(lines, line)).error) refused.push(line);
      left = refused;
    }
    await this.page.order("settings");
    return this.page.say(left.length ? _("Refused: {lines}", { lines: left.join("  ") }) : _("{count} lines are restored.", { count }));
  }
}
