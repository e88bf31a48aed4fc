// The jobs that the board keeps in its flash: a row of the job's card, shown if there are any to be kept.

import { grey } from "./controls.js";
import { wrongLetter } from "./job_facts.js";
import { crc32, deflate, jobBytes, unaccented } from "./pack.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const NAME_MOST = 24;
const storedName = (name) => unaccented(name).toUpperCase().replace(/[^A-Z0-9._-]/g, "_").replace(/^\.+/, "").slice(-NAME_MOST);

export class Kept {
  // order(name, fields): a promise of the answer; ask(text): of a yes; report(): the newest state; chosen(): the page's own job;
  // say(text): tell; language(): the board's.
  constructor(order, ask, report, chosen, say, language) {
    Object.assign(this, { order, ask, report, say, language });
    this.piece = 0;  // bytes of an upload in a message, where the board itself serves the page
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
      const job = chosen(), kept = storedName(job);
      if (!(await this.mayReplace(kept))) return;
      order("stored", { what: "store", name: kept, job });
      this.known = false;
    };
    $("kept-upload").onchange = async () => { if ($("kept-upload").files[0]) await this.upload($("kept-upload").files[0]); $("kept-upload").value = ""; };
    $("kept-row").hidden = true;
  }

  async mayReplace(name) {
    return ![...$("kept").options].some((option) => option.value === name) || this.ask(_("Replace {name}?", { name }));
  }

  // A file of this computer to the flash of the board that serves the page: piece by piece, then it is read back whole.
  async upload(file) {
    const name = storedName(file.name), job = jobBytes(this.language(), await file.arrayBuffer());
    if (job && job.letter) return this.say(wrongLetter(job));
    if (job && job.line) return this.say(_("Line {line}, {text}: a job may not have it, give it by hand", job));
    if (!job) return this.say(_("{name} is no job of this machine's language.", { name: file.name }));
    this.say("");
    if (!(await this.mayReplace(name))) return;
    const packed = deflate(job);
    const does = (what, more) => this.order("stored", { what, name, ...more });
    const crc = crc32(job).toString(16).padStart(8, "0");
    let answer = await does("begin", { size: job.length, crc, stored: packed.length });
    for (let at = 0; at < packed.length && !answer.error; at += this.piece) {
      answer = await does("piece", { at, data: btoa(String.fromCharCode(...packed.subarray(at, at + this.piece))) });
    }
    if (!answer.error) await does("end");
    this.known = false;
  }

  // A text as a job of the board: by the PC's folder of jobs, or straight to the board that serves the page.
  async keepText(name, text) {
    if (this.piece) return this.upload(new File([text], name));
    const kept = storedName(name);
    if (!(await this.mayReplace(kept)) || (await this.order("job_part", { name, at: 0, text, last: true })).error) return null;
    if (!(await this.order("stored", { what: "store", name: kept, job: name })).error) {
      do await new Promise((seen) => setTimeout(seen, 300)); while ((this.report().job || {}).how === "store");
    }
    this.known = false;
    return this.order("job_remove", { name });
  }

  // The list, as the server tells it.
  take(message) {
    $("kept-row").hidden = !message.jobs;
    if (!message.jobs) return;
    this.piece = message.piece || 0;
    const before = $("kept").value;
    $("kept").replaceChildren(...message.jobs.map(([name, size]) => new Option(`${name} (${Math.ceil(size / 1024)} kB)`, name)));
    if (message.jobs.some(([name]) => name === before)) $("kept").value = before;
    for (const id of ["kept-list", "kept-check", "kept-run", "kept-remove"]) $(id).hidden = !message.jobs.length;
    if (this.piece) $("kept-check").hidden = true;
    $("keep").hidden = Boolean(this.piece);
    $("kept-free").textContent = _("{free} MB free on the board", { free: (message.free / 1048576).toFixed(1) }) +
      (message.more ? `; ${_("{more} more jobs are not listed", message)}` : "");
  }

  // Ask for the list once the machine is at rest; `why`: of what is grey.
  show(why) {
    const rest = why.mine || why.rest;
    for (const id of ["kept-run", "kept-check", "kept-remove"]) grey($(id), rest || ($("kept").value ? "" : _("Choose a file first.")));
    grey($("keep"), rest || why.chosen);
    grey($("kept-upload"), rest);
    if (this.known || rest) return;
    this.known = true;
    this.order("stored", { what: "list" }).then((answer) => { if (answer.error && answer.error !== 102) this.known = false; });
  }
}
