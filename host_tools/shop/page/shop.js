// The shop's page: all machines, the queue, and files that are dropped.

import { _, choose, preferred } from "./words.js";
import { explain, showTitles } from "./titles.js";
import { Link } from "./link.js";
import { read } from "./gcode_path.js";
import { decode } from "./program.js";
import { element, said, states } from "./tiles.js";
import { pieces } from "./pieces.js";
import { paint, thumbnail } from "./thumbnail.js";

const at = (id) => document.getElementById(id);
const HOW = { rest: "not released", free: "free: paper is in", fetch: "its file comes", run: "draws", waits: "waits for somebody at the machine", goes: "gets ready" };
const ENDED = { done: "done", "given up": "given up", refused: "refused", left: "ended here" };
const KEY = "passo-shop-key";
const MOST_TOLD = 8;  // files of which something is said
const KEPT = 3;  // choices of the filter that are always there
const programs = new Map();  // sha: its thumbnail, or null while it comes
const tiles = new Map();
let state = { machines: [], adrift: [], jobs: [], counts: {}, used: [], broker: true };
let lists = "";

const clock = (seconds) => {
  const whole = Math.max(0, Math.round(seconds)), two = (n) => String(n).padStart(2, "0");
  return whole >= 3600 ? `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}` : `${Math.floor(whole / 60)}:${two(whole % 60)}`;
};

const link = new Link(hear, (up) => { at("lost").hidden = up; });

function hear(message) {
  if (message.t === "hello") options(at("kind"), message.kinds, 0);
  if (message.t === "dropped") tell(message.name, () => said(message.text) || _("{name}: {copies} in the queue.", message));
  if (message.t === "state") {
    state = message;
    show();
  }
}

let telling = [];  // [file, what()], the oldest first

// `what()`: the text, in the language of the page, which may be another one later.
function say(what) {
  telling = [];
  tell("", what);
}

// The same of a file: what is said of others stays.
function tell(file, what) {
  telling = [...telling.filter(([other]) => other && other !== file), [file, what]].slice(-MOST_TOLD);
  at("said").textContent = telling.map(([, text]) => text()).join("\n");
}

// Those behind the first `kept` ones.
function options(select, values, kept) {
  const now = select.value;
  while (select.options.length > kept) select.remove(select.options.length - 1);
  for (const value of values) {
    const made = element("option", "", value);
    made.value = value;
    select.append(made);
  }
  if ([...select.options].some((each) => each.value === now)) select.value = now;
}

// --- machines

function tile(name) {
  const made = element("article", "tile");
  const parts = { title: element("h2", "", name), state: element("p", "state"), canvas: element("canvas"), job: element("p", "file"), left: element("p", "left"), why: element("p", "why") };
  made.append(...Object.values(parts));
  tiles.set(name, { made, ...parts, drawn: "" });
  at("machines").append(made);
  return tiles.get(name);
}

function laser(has) { return has.laser ? _("laser class {laser}", has) : ""; }

function kindOf(machine) { return machine.tool ? `${machine.kind} · ${machine.tool}` : machine.kind || ""; }

function show() {
  at("no-broker").hidden = state.broker;
  at("trouble").hidden = !state.trouble;
  const trouble = said(state.trouble);
  if (at("trouble").firstElementChild.textContent !== trouble) at("trouble").firstElementChild.textContent = trouble;
  const kinds = [...new Set(state.machines.flatMap((machine) => [machine.language, kindOf(machine)]))].filter((each) => each).sort();
  if (kinds.join() !== [...at("filter").options].slice(KEPT).map((each) => each.value).join()) options(at("filter"), kinds, KEPT);
  const jobs = new Map(state.jobs.map((job) => [job.id, job]));
  const named = new Set(state.machines.map((machine) => machine.name));
  for (const [name, known] of tiles) if (!named.has(name)) { known.made.remove(); tiles.delete(name); }
  const last = new Map();
  for (const job of state.jobs) if (job.state in ENDED && !last.has(job.machine)) last.set(job.machine, job);
  for (const machine of state.machines) draw(machine, tiles.get(machine.name) || tile(machine.name), jobs.get(machine.job), last.get(machine.name));
  const free = state.machines.filter((machine) => machine.how === "free" && machine.state !== "gone").length;
  const waits = state.machines.filter((machine) => machine.how === "waits").length;
  at("counts").textContent = _("{machines} machines, {free} free, {waits} wait for somebody; {queued} jobs in the queue, {done} done.", {
    machines: state.machines.length, free, waits, queued: state.counts.queued || 0, done: state.counts.done || 0,
  });
  const text = JSON.stringify([state.jobs, state.adrift, state.used, document.documentElement.lang, !link.key]);
  if (text !== lists) {
    lists = text;
    showLists();
  }
}

// `last`: the job of the machine that has ended last, shown until there is another.
function draw(machine, shown, job, last) {
  const gone = machine.state === "gone" || machine.state === "lost";
  shown.made.className = `tile how-${gone ? "gone" : machine.how} state-${machine.state}`;
  const wanted = at("filter").value;
  const fits = wanted === "" || ["=" + machine.how, machine.language, kindOf(machine)].includes(wanted);
  shown.made.hidden = !fits || gone && wanted.startsWith("=");
  if (machine.page && !shown.title.firstElementChild) {
    const leads = element("a", "", machine.name);
    leads.href = machine.page;
    shown.title.replaceChildren(leads);
  }
  shown.state.textContent = [states[machine.state] ? _(states[machine.state]) : _("not heard of yet"), gone ? "" : _(HOW[machine.how] || ""), laser(machine)].filter((each) => each).join(" · ");
  const name = job ? job.name : machine.job || (last ? `${last.name} · ${_(ENDED[last.state])}` : "");
  shown.job.textContent = machine.progress ? `${name} · ${machine.progress} %` : name;
  shown.left.textContent = machine.left ? _("{time} left", { time: clock(Number(machine.left)) }) : "";
  shown.why.textContent = [machine.how === "waits" && machine.line ? _("It stopped behind line {line}.", machine) : "", said(machine.text), said(machine.alarm)].filter((each) => each).join(" ");
  if (job || machine.job || !last) picture(shown, job, Number(machine.progress || 0));
  else picture(shown, last, last.state === "done" ? 100 : 0);
}

function picture(shown, job, progress) {
  const drawing = job ? program(job) : null;
  const key = drawing ? `${job.sha} ${progress} ${shown.canvas.clientWidth}` : "";
  shown.canvas.hidden = !drawing;
  if (key === shown.drawn) return;
  shown.drawn = key;
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
  if (drawing) paint(shown.canvas, drawing, progress, { path: colour("--path"), done: colour("--done") });
}

function program(job) {
  if (!programs.has(job.sha)) {
    programs.set(job.sha, null);
    fetch(`job/${job.id}`).then((answer) => answer.text()).then((text) => programs.set(job.sha, thumbnail(read(text)))).catch(() => programs.delete(job.sha));
  }
  return programs.get(job.sha);
}

// --- the queue

function showLists() {
  const waits = state.jobs.filter((job) => job.state === "queued");
  const ended = state.jobs.filter((job) => job.state in ENDED);
  const adrift = state.jobs.filter((job) => state.adrift.includes(job.id));
  at("adrift").hidden = !adrift.length;
  at("adrift").querySelector("ul").replaceChildren(...adrift.map((job) => row(job, [job.machine, job.line ? _("It stopped behind line {line}.", job) : "", said(job.text)], _("End the job"), "end")));
  at("queue").replaceChildren(...waits.map((job) => row(job, [job.wants.kind, job.wants.tool, laser(job.wants), job.wants.seconds ? clock(job.wants.seconds) : ""], _("Withdraw"), "withdraw")));
  at("history").replaceChildren(...ended.map((job) => row(job, [_(ENDED[job.state]), job.machine, said(job.text)], _("Again"), "again")));
  at("used").replaceChildren(...state.used.map(([material, jobs, seconds]) => {
    const made = element("tr");
    made.append(element("td", "", material || _("not named")), element("td", "", jobs), element("td", "", clock(seconds)));
    return made;
  }));
  at("open").hidden = Boolean(link.key);
  at("add").hidden = !link.key;
}

function row(job, facts, text, what) {
  const made = element("li"), button = element("button", "", text);
  made.append(element("strong", "", job.name), document.createTextNode(` ${facts.filter((each) => each).join(" · ")} `));
  button.addEventListener("click", async () => complain(await link.order({ do: what, job: job.id })));
  if (link.key) made.append(button);
  return made;
}

let errors = {};
fetch("texts/refused.json").then((answer) => answer.json()).then((texts) => { errors = texts; });

function complain(answer, file = "") {
  const text = () => _("Refused: {text}", { text: said(errors[answer.error]) || answer.error });
  if (answer.error && file) tell(file, () => `${file}: ${text()}`);
  else if (answer.error) say(text);
  return answer.error;
}

let sending = Promise.resolve();  // one file after the other, whatever is dropped meanwhile

function queue(files) {
  if (!files.length) say(() => _("Choose a file first."));
  const more = { kind: at("kind").value, copies: Number(at("copies").value), tool: at("tool").value, laser: at("laser").value, material: at("material").value };
  for (const file of [...files]) sending = sending.then(() => send(file, more)).catch(() => tell(file.name, () => _("{name} cannot be read.", file)));
}

async function send(file, more) {
  const text = decode(await file.arrayBuffer());
  tell(file.name, () => _("{name} is checked…", file));
  for (const piece of pieces(text)) if (complain(await link.order({ do: "drop", name: file.name, ...piece, ...more }), file.name)) return;
}

at("add").addEventListener("submit", (event) => { event.preventDefault(); queue(at("file").files); });
at("open").addEventListener("submit", (event) => { event.preventDefault(); useKey(at("key").value); });
at("filter").addEventListener("change", show);
document.addEventListener("dragover", (event) => event.preventDefault());
document.addEventListener("drop", (event) => { event.preventDefault(); if (event.dataTransfer.files.length) queue(event.dataTransfer.files); });
// The answer says whether the broker has it.
async function stop() {
  const sent = await fetch("stop", { method: "POST" }).then((answer) => answer.ok && answer.json()).then((answer) => answer && answer.error === 0).catch(() => false);
  say(() => sent ? _("STOP has been sent to all machines. Look at them.") : _("STOP was not sent. Use the emergency stops."));
}

at("stop").addEventListener("click", stop);
document.addEventListener("keydown", (event) => { if (event.key === "Escape" && !event.repeat) stop(); }, true);

function useKey(text) {
  link.key = text.toUpperCase().replace(/[^A-Z2-9]/g, "");
  sessionStorage.setItem(KEY, link.key);
  lists = "";
  show();
}

const given = /key=([A-Z2-9]+)/.exec(location.hash);
if (given) history.replaceState(null, "", location.pathname);
useKey(given ? given[1] : sessionStorage.getItem(KEY) || "");
at("language").addEventListener("change", async () => { await choose(at("language").value); showTitles(true); lists = ""; at("said").textContent = telling.map(([, text]) => text()).join("\n"); show(); });
at("language").value = preferred();
choose(at("language").value).then(() => { showTitles(true); lists = ""; show(); });

explain(() => [
  ["#language", _("Language of this page")],
  ["#stop", _("Stops every machine of the shop at once, and drops their jobs")],
  ["#key", _("The letters that the shop has printed in its terminal")],
  ["#open button", _("Lets this page queue jobs from now on")],
  ["#filter", _("Which machines are shown")],
  ["#file", _("Files of this PC that become jobs")],
  ["#kind", _("The machines that may take the job")],
  ["#copies", _("How many times the job is made")],
  ["#tool", _("Only machines with this pen or tool take the job")],
  ["#laser", _("Only lasers up to this class take the job")],
  ["#material", _("Only machines with this material take the job")],
  ["form button", _("Puts the files behind the jobs that wait")],
  ["li button", _("Changes this job's place in the queue, or ends it")],
  ["a[href]", _("Opens the page of this machine")],
  ["canvas", _("Picture of the job under way")],
  ["button", _("Does to this machine or job what it says")],
  ["[tabindex]", _("More about this machine or job")],
]);
