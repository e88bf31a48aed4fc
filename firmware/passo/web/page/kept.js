// The jobs that the board keeps in its flash: a row of the job's card, shown if there are any to be kept.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const NAME_MOST = 24;

export class Kept {
  // order(name, fields): a promise of the answer; ask(text): of a yes; report(): the newest state; chosen(): the page's own job.
  constructor(order, ask, report, chosen) {
    this.order = order;
    this.report = report;
    this.known = false;
    const name = () => $("kept").value;
    const does = (what, more = {}) => order("stored", { what, name: name(), ...more });
    $("kept-run").onclick = () => does("run");
    $("kept-check").onclick = () => does("run", { check: true });
    $("kept-remove").onclick = async () => {
      if (!(await ask(_("Remove {name} from the board?", { name: name() })))) return;
      await does("delete");
      this.known = false;
    };
    $("keep").onclick = async () => {
      const job = chosen(), kept = job.toUpperCase().replace(/[^A-Z0-9._-]/g, "_").replace(/^\.+/, "").slice(-NAME_MOST);
      if ([...$("kept").options].some((option) => option.value === kept) && !(await ask(_("Replace {name}?", { name: kept })))) return;
      order("stored", { what: "store", name: kept, job });
      this.known = false;
    };
    $("kept-row").hidden = true;
  }

  // The list, as the server tells it.
  take(message) {
    $("kept-row").hidden = !message.jobs;
    if (!message.jobs) return;
    const before = $("kept").value;
    $("kept").replaceChildren(...message.jobs.map(([name, size]) => new Option(`${name} (${Math.ceil(size / 1024)} kB)`, name)));
    if (message.jobs.some(([name]) => name === before)) $("kept").value = before;
    for (const id of ["kept-list", "kept-check", "kept-run", "kept-remove"]) $(id).hidden = !message.jobs.length;
    $("kept-free").textContent = _("{free} MB free on the board", { free: (message.free / 1048576).toFixed(1) });
  }

  // Ask for the list once the machine is at rest; `free`: nothing runs, and this page commands.
  show(free) {
    const state = this.report().state;
    const rest = free && ["Idle", "Alarm"].includes(state);
    for (const id of ["kept-run", "kept-check", "kept-remove"]) $(id).disabled = !rest || !$("kept").value;
    $("keep").disabled = !rest || !$("jobs").value;
    if (this.known || !rest) return;
    this.known = true;
    this.order("stored", { what: "list" }).then((answer) => { if (answer.error && answer.error !== 102) this.known = false; });
  }
}
