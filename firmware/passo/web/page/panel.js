// The page: shows what the server pushes, and makes orders of what is pressed.

import "./old.js";
import { Cards } from "./cards.js";
import { grey, makeOverrides, nameTool, onOff, reasons, showControls, showWait, switchWork, toolName } from "./controls.js";
import { Jog } from "./jog.js";
import { JobFacts, dropped } from "./job_facts.js";
import { Kept } from "./kept.js";
import { Link } from "./link.js";
import { open as openDialog, shut } from "./modal.js";
import { OwnButtons } from "./own_buttons.js";
import { unaccented } from "./pack.js";
import { makePad } from "./pad.js";
import { Picture } from "./path.js";
import { read } from "./gcode_path.js";
import { Place } from "./place.js";
import { decode } from "./program.js";
import { Queue } from "./queue.js";
import { Recover } from "./recover.js";
import { Settings } from "./settings.js";
import { Tabs } from "./tabs.js";
import { Typed } from "./typed.js";
import { sentences } from "./help.js";
import { explain, showTitles } from "./titles.js";
import { _, choose as chooseWords, languages, preferred } from "./words.js";

const $ = (id) => document.getElementById(id);
const TWICE_MS = 700;
const NEAR_MM = 0.5;  // more than a step of any machine
const PIECE = 30000;  // characters of a job in one message
const SIGNALS = { X: "Limit X", Y: "Limit Y", Z: "Limit Z", A: "Limit A", P: "Probe", D: "Door", H: "Hold button", R: "Reset button", S: "Start button" };
const MORE = { En: "Encoders", RPM: "Spindle, turns a minute", Gl: "Glitches of inputs", Nh: "Not homed", Vac: "Vacuum cleaner", Clamp: "Clamp", Fb: "Inputs that forbid" };  // words of a status that only some machines have
const STATES = { "": "No link", Idle: "Ready", Run: "Running", Hold: "Held", Jog: "Moving", Home: "Homing", Alarm: "Alarm", Door: "Door open",
  Check: "Checking", Sleep: "Asleep" };
const KEYS = { ArrowLeft: "x-", ArrowRight: "x+", ArrowUp: "y+", ArrowDown: "y-", PageUp: "z+", PageDown: "z-" };

let report = { state: "", beat: 0, m: [], w: [] };
let errors = {};
let axes = "";
let turns = "";  // those of them that count degrees
let rules = {};
let settings = {};
let travel = null;  // [[low, high]] of each axis, where no settings say it
let job = { name: "", text: "", lines: [] };
const link = new Link(told, up);
const jog = new Jog(link, () => report, refuse, refresh);
const shelf = new Kept((name, fields) => link.order({ do: name, ...fields }).then((answer) => { refuse(answer.error === 102 ? 0 : answer.error); return answer; }),
  ask, () => report, () => $("jobs").value, say, () => language);
const recover = new Recover((name, fields) => order(name, fields), () => $("jobs").value);
const queue = new Queue((name, fields) => order(name, fields), { job: () => $("jobs").value, choose, text: textOf, about: (name) => link.order({ do: "job_about", name }), moves: movesOf });
const picture = new Picture($("path"), touched);
const place = new Place(order, picture, () => load());
const facts = new JobFacts((name, fields) => link.order({ do: name, ...fields }), picture, (about) => place.take(about), errorText);
const cards = new Cards({ order, ask, picture, say, upload: (file) => (cards.can("jobs") ? upload(file) : shelf.upload(file)), report: () => report, proven: () => $("card-key").hidden && link.ready(), until });
let language = "";
let setup = null;  // once it has been loaded
let prove = null, board = null;  // likewise
const list = new Settings({ order, ask, say, axes: () => axes, turns: () => turns, rules: () => rules, lines: () => (cards.can("line") ? loadSetup().then((made) => made.lines) : null) });
const tabs = new Tabs(() => { picture.draw(); if (language === "grbl" && !$("pane-setup").hidden) loadSetup(); });
const typed = new Typed(order, errorText);
const own = new OwnButtons(order, ask, atRest, stops);
let waiting = [];  // [condition of a job, resolve]
let starting = false;  // a job has been asked to run: the end of the one before is told no more

// --- messages

function say(text) { $("message").textContent = text; }
let dismissed = "";  // the caution that somebody has touched away: it is not said again
$("message").onclick = () => {
  if ($("message").textContent === alarmText) dismissed = alarmText;
  say("");
};

function errorText(error) { return `${_("Error")} ${error}: ${_(errors[error] || "")}`; }

// `answer`: an order's, which may say more.
function refuse(error, { text = "", line = 0 } = {}) {
  if (error) say(text || [errorText(error), line ? _("line {line}", { line }) : ""].filter(Boolean).join(", "));
}

// True once the machine is at rest again; false if it is not, or has stopped for another reason.
async function atRest() {
  const moves = () => ["Run", "Jog", "Home"].includes(report.state);
  await new Promise((seen) => setTimeout(seen, 200));
  while (moves()) await new Promise((seen) => setTimeout(seen, 100));
  return report.state === "Idle";
}

// A value that changes if any page presses STOP or jogs.
function stops() { return [link.stops, report.lease].join(); }

// An order; what is refused is said. Returns the answer.
async function order(name, fields = {}) {
  if (setup && setup.locked() && !["hold", "resume", "override", "jobs", "log", "settings"].includes(name)) return { error: 8 };
  const answer = await link.order({ do: name, ...fields });
  if (answer.error) refuse(answer.error, answer); else if (name !== "jobs") say("");
  return answer;
}

function ask(text) {
  $("ask-text").textContent = text;
  return new Promise((answer) => {
    openDialog($("ask"), () => answer(false));
    $("ask-yes").onclick = () => { answer(true); shut(); };
    $("ask-no").onclick = shut;
    $("ask-yes").focus();
  });
}

// A table of the server's, {} if it has none.
async function table(name) {
  const found = await fetch(name).catch(() => null);
  return found && found.ok ? found.json() : {};
}

// True once a report has a job as wanted; false after two seconds.
function until(wanted) {
  return new Promise((done) => {
    waiting.push([wanted, done]);
    setTimeout(() => done(false), 2000);
  });
}

// --- what comes

function up(open) {
  if (!open) {
    if (setup) setup.halt();
    jog.release();
    report = { ...report, state: "", link: false };
    show();
    say(_("The link to the panel is lost. Trying again…"));
    return;
  }
  say("");
  if (jog.seldom()) link.look(refresh());
  useKey();
}

async function useKey() {
  const proven = Boolean(link.key) && !(await link.order({ do: "jobs" }).then(takeJobs)).error;
  $("card-key").hidden = proven;
  if (link.key && !proven) say(_("This key is not the panel's."));
  if (proven) {
    await link.order({ do: "settings" });
    await link.order({ do: "log" });
    shelf.known = false;
    if (cards.can("prove")) script("card_prove.js").then(lookAtProof);
    if (cards.can("board")) script("card_board.js").then(() => { board = board || new window.PassoBoard({ order, ask, say }); });
  }
}

function lookAtProof() {
  prove = prove || new window.PassoProve({ order, ask });
  link.order({ do: "prove", what: "get" });
}

function told(message) {
  if (message.t === "state") {
    report = message;
    jog.report();
    show();
  } else if (message.t === "hello" || message.t === "machine") {
    const other = Boolean(language) && language !== message.language || message.t === "machine";
    language = message.language;
    hello(message);
    if (other) anew();
  } else if (message.t === "settings") {
    setAxes(message.axes, "turns" in message ? message.turns : turns);
    showSettings(message.settings);
  } else if (message.t === "jobs") {
    takeJobs(message);
  } else if (message.t === "stored") {
    shelf.take(message);
    own.onBoard(message.jobs && message.jobs.map(([name]) => name), shelf);
  } else if (message.t === "prove") {
    if (prove) prove.told(message);
  } else if (message.t === "machines") {
    showMachines(message.machines, $("machines").value);
  } else if (message.t === "changing") {
    say(_("The board becomes {name}: this may take a minute…", { name: message.name }));
  } else if (message.t === "refused") {
    say(message.text);
  } else if (message.t === "asks") {
    say(_("A program at {name} wants to move the machine. “Let the other program move it” lets it.", { name: message.name }));
  } else if (message.t === "log") {
    showLog(message);
  } else if (message.t === "said") {
    if (!(setup && setup.heard(message.text))) typed.say(message.text);
  }
}

// Another machine: what was shown of the one before is of no use.
function anew() {
  job = { name: "", text: "", lines: [] };
  for (const id of ["jobs", "lines", "settings", "log"]) $(id).replaceChildren();
  for (const id of ["job-state", "said"]) $(id).textContent = "";
  $("progress").hidden = true;
  picture.show([]);
  say("");
  useKey();
}

function hello(message) {
  $("address").textContent = location.origin;
  if (message.rules) rules = message.rules;
  else table("rules.json").then((found) => { rules = found; });
  cards.hello(message);
  travel = message.travel || null;
  settings = {};
  axes = "";
  $("home").hidden = !message.can.includes("home");
  $("unlock").hidden = !message.can.includes("unlock");
  setAxes(message.axes, message.turns || "");
  const machines = message.machines || [];
  $("machine-row").hidden = !machines.length;
  showMachines(machines, machines[0]);
  tabs.show();
}

function showMachines(names, chosen) {
  $("machines").replaceChildren(...names.map((name) => new Option(name || "—", name, false, name === chosen)));
}

const unit = (axis) => (turns.includes(axis) ? "°" : "mm");

function setAxes(wanted, turned) {
  if (wanted === axes && turned === turns) return;
  axes = wanted;
  turns = turned;
  for (const place of document.querySelectorAll("[data-turns]")) place.textContent = turns ? `, ${turns.toUpperCase()}:\u00a0${place.dataset.turns}` : "";
  $("places").replaceChildren(...[...axes].map((axis) => {
    const row = document.createElement("tr");
    row.innerHTML = `<th scope="row">${axis.toUpperCase()} <small>${unit(axis)}</small></th><td id="w-${axis}"></td><td id="m-${axis}"></td><td><button type="button">${axis.toUpperCase()} = 0</button></td>`;
    row.querySelector("button").onclick = () => order("zero", { axes: axis });
    row.lastChild.hidden = !cards.can("zero");
    return row;
  }));
  $("goto-axes").replaceChildren(...[...axes].map((axis) => {
    const label = document.createElement("label");
    label.innerHTML = `<span data-as-is>${axis.toUpperCase()}, ${unit(axis)}</span><input type="number" step="any" id="goto-${axis}">`;
    return label;
  }));
  makePad($("pad"), axes, turns, cards.can("diagonal"), press, (button) => jog.release(button));
}

// --- what is shown

let alarmText = "";  // what was said of the alarm, or of axes that are not homed

// Letters of the axes that are not homed, while soft limits are on and so do not hold; in an alarm nothing moves.
function unlimited() {
  const [, unhomed] = (report.more || []).find(([word]) => word === "Nh") || [];
  return unhomed && (settings[20] !== "0" || settings[22] === "0") && report.link !== false ? [...unhomed].join(" ") : "";
}

function show() {
  const number = report.state || "";
  $("state").dataset.state = number;
  const braking = ["Hold", "Door"].includes(number) && report.sub !== "0";
  let name = braking ? _("Stopping") : _(STATES[report.link === false ? "" : number] || number);
  if ($("state-name").textContent !== name) $("state-name").textContent = name;
  [...axes].forEach((axis, n) => {
    $(`w-${axis}`).textContent = report.w && n in report.w ? report.w[n].toFixed(3) : "";
    $(`m-${axis}`).textContent = report.m && n in report.m ? report.m[n].toFixed(3) : "";
  });
  showWhere();
  $("speed-now").textContent = Math.round(report.feed || 0);
  $("rpm-now").textContent = Math.round(report.rpm || 0);
  showControls(report);
  showWait(report, report.owner !== "guest", report.state === "Idle" ? Queue.waits(report) : null);
  if (setup) setup.show();
  $("owner").textContent = report.owner === "guest" ? _("the sender beside it") : _("this page");
  showSignals();
  showJob();
  if (report.teaching !== undefined) $("teach-state").textContent = report.teaching < 0 ? "" : _("Recording: {count} places", { count: report.teaching });
  if (report.alarm) {
    refuse(report.alarm);
    alarmText = $("message").textContent;
  } else if (number === "Alarm") {
    alarmText = _("Locked: press Home, or Unlock if the position is right as it is.");
    if (!$("message").textContent) say(alarmText);
  } else {
    const unhomed = unlimited(), said = alarmText && $("message").textContent === alarmText;
    alarmText = unhomed ? _("Not homed: {axes}. The machine keeps to no travel limits until it is.", { axes: unhomed }) : "";
    if (alarmText !== dismissed) dismissed = "";
    if (said || !$("message").textContent) say(alarmText === dismissed ? "" : alarmText);
  }
  enable();
}

// The place in the head, to be read from afar.
function showWhere() {
  const shown = [axes, turns, (report.w || []).length].join();
  if ($("where").dataset.shown !== shown) {
    $("where").dataset.shown = shown;
    $("where").replaceChildren(...(report.w || []).map((value, n) => {
      const place = document.createElement("span");
      place.innerHTML = `<b></b> <span></span> <small>${unit(axes[n])}</small>`;
      place.firstChild.textContent = (axes[n] || "").toUpperCase();
      return place;
    }));
  }
  (report.w || []).forEach((value, n) => { $("where").children[n].children[1].textContent = value.toFixed(2); });
}

function enable() {
  const state = report.state, locked = state === "Alarm";
  const busy = Boolean(report.job) && ["load", "run", "halting", "store"].includes(report.job.how);
  const why = reasons(report, busy), mine = !why.mine;
  const set = (id, text) => grey($(id), text);
  showLock(locked);
  for (const id of ["run", "check"]) set(id, why.mine || why.idle || why.chosen);
  for (const id of ["zero-all", "teach-begin", "teach-save"]) set(id, why.rest);
  set("remove", why.rest || why.chosen);
  for (const button of document.querySelectorAll("#machine, #prove, [data-stands]")) grey(button, why.mine || (report.link === false && !busy ? "" : why.rest));
  set("home", why.mine || why.rest);
  set("unlock", why.mine || (locked ? "" : _("The machine is not locked.")));
  set("hold", ["Run", "Jog", "Home"].includes(state) ? "" : _("Nothing moves."));
  set("resume", why.mine || (["Hold", "Door"].includes(state) ? "" : _("Nothing is held.")));
  set("abort", busy ? "" : _("No job is under way."));
  const still = ["Alarm", "Home", "Run", "Check", "Sleep", "Door"].includes(state) || report.link === false;
  if ($("pad").dataset.off !== String(still)) $("pad").dataset.off = still;
  for (const key of $("pad").querySelectorAll("button")) if (key.getAttribute("aria-disabled") !== String(still)) key.setAttribute("aria-disabled", still);
  const moves = picture.moves.length ? facts.beyond : _("This file moves nothing.");
  set("round", why.mine || why.idle || why.chosen || moves);
  const told = busy || !cards.can("jobs") ? "" : $("run").dataset.why || "";  // a finger has no other way to ask
  if ($("run-why").textContent !== told) $("run-why").textContent = told;
  showPause();
  set("give", why.idle);
  set("take", state === "Idle" || locked ? "" : why.rest);
  $("give").hidden = !mine;
  $("take").hidden = mine;
  $("card-log").hidden = !cards.can("log") || !$("log").children.length;
  cards.show(report, why);
  // A running job has no use for these, and a phone little room.
  $("passes").parentNode.hidden = busy || !cards.can("jobs");
  $("round").hidden = busy || !cards.can("jobs") || !cards.can("goto");
  $("from-form").hidden = busy || !cards.can("from");
  $("pictures-row").hidden = busy || !cards.can("jobs");
  queue.show(report.queue, why);
  const offer = report.recover;
  recover.show(busy && !(offer && offer.next) ? null : offer, { ...why, busy: busy ? why.rest : "" }, /[SC]/.test(report.on || ""));
  if (link.key && $("card-key").hidden) shelf.show(why);
}

// In an alarm a phone begins with what ends it. After it the keys that move come to the same spot: who taps twice there moves nothing.
function showLock(locked) {
  const { dataset } = document.body;
  if (dataset.locked === String(locked)) return;
  if (dataset.locked === "true") {
    document.body.classList.add("settles");
    setTimeout(() => document.body.classList.remove("settles"), TWICE_MS);
  }
  dataset.locked = locked;
  $("home").className = locked ? "go" : "";
}

// Pause or Resume, always in sight while there is something to pause. It says the other thing after a moment: who taps twice has paused.
function showPause() {
  const pause = $("pause"), held = !$("resume").disabled, word = held ? "Resume" : "Pause";
  pause.hidden = !(held || report.state === "Run" && !$("hold").disabled) || !cards.can("hold") || !$("wait-bar").hidden;
  if (pause.textContent === _(word)) return;
  pause.textContent = _(word);
  pause.dataset.does = held ? "resume" : "hold";
  pause.className = held ? "go" : "";
  pause.disabled = true;
  setTimeout(() => { pause.disabled = false; }, TWICE_MS);
}

// What was touched in the picture: a place to go to, and the line of the path there.
function touched(place, move) {
  if (place) ["x", "y"].forEach((axis, n) => { if ($(`goto-${axis}`)) $(`goto-${axis}`).value = place[n].toFixed(1); });
  if (move) mark(move.line);
  tellLine(move ? move.line : 0);
}

function tellLine(line) {
  const text = line ? `${_("line {line}", { line })}: ${job.lines[line - 1] || ""}` : "";
  if (line && report.state !== "Run") $("from-line").value = line;
  if ($("path-line").textContent !== text) $("path-line").textContent = text;
}

// The travel, as the work's coordinates have it: of a machine with settings these say it.
function showTable() {
  const { m, w } = report;
  const told = axes && rangeOf();
  if (!told || !m || !w || m.length < 2) return;
  const zero = [0, 1, 2].map((axis) => (axis in m ? w[axis] - m[axis] : 0));
  const box = [0, 1, 2].map((axis) => (told[axis] || [0, 0]).map((end) => Math.round((end + zero[axis]) * 100) / 100));
  if (picture.setTable({ box, zero })) facts.tell();
}

// [[low, high]] of the axes in machine coordinates, mm; $130 … of grbl, and $23: which axes home at their low end.
function rangeOf() {
  if (!("130" in settings)) return travel;
  return Array.from(axes, (axis, n) => {
    const far = Number(settings[130 + n]) || 0;
    return Number(settings[23] || 0) >> n & 1 ? [0, far] : [-far, 0];
  });
}

function showSignals() {
  const on = report.pins || "";
  const outputs = report.on || "";
  const rows = Object.entries(SIGNALS).filter(([letter]) => "XYZA".indexOf(letter) < axes.length || letter > "B" && !"XYZ".includes(letter))
    .map(([letter, name]) => [_(name), on.includes(letter), onOff(name, on.includes(letter))]);
  if (/n/i.test(on)) rows.push([_("Somebody at the machine"), on.includes("N"), on.includes("N") ? _("Yes") : _("No")]);
  for (const [name, is] of [["", /[SC]/], ["Coolant", /F/], ["Mist", /M/]]) rows.push([name ? _(name) : toolName(), is.test(outputs), onOff(name, is.test(outputs))]);
  const elsewhere = ["SD", "Al", ...(alarmText && $("message").textContent === alarmText ? ["Nh"] : [])];  // the message says who is not homed
  rows.push(...(report.more || []).filter(([word]) => !elsewhere.includes(word)).map(([word, text]) => [MORE[word] ? _(MORE[word]) : word, null, text]));
  const text = JSON.stringify(rows);
  if ($("signals").dataset.shown === text) return;
  $("signals").dataset.shown = text;
  $("signals").replaceChildren(...rows.map(([name, active, said]) => {
    const item = document.createElement("li");
    item.innerHTML = "<span></span><b></b>";
    item.firstChild.textContent = `${name}: `;
    item.lastChild.textContent = said;
    item.className = active ? "on" : "";
    return item;
  }));
}

function showJob() {
  const now = report.job;
  const line = now ? (["run", "halting"].includes(now.how) && report.line) || now.line : 0;
  showTable();
  if (report.w && report.w.length) picture.move(report.w, now && now.name === job.name ? (now.how === "done" ? Infinity : line) : 0);
  for (const [wanted, done] of waiting) if (wanted(now)) done(true);
  waiting = waiting.filter(([wanted]) => !wanted(now));
  facts.show(now, report);
  if (!now) return;
  $("progress").hidden = false;
  $("progress").value = now.lines ? now.done / now.lines : 0;
  let text = cards.told(now) || described(now, line);
  if (now.error) text += `. ${_("Error")} ${now.error}: ${_(errors[now.error] || "")}`;
  if (!starting && $("job-state").textContent !== text) $("job-state").textContent = text;
  if (now.name === job.name && !cards.mark(now)) mark(line);
  if (now.name === job.name && now.how === "run") tellLine(line);
}

// What is said of a job of lines.
function described(now, line) {
  const held = report.state === "Hold";
  const how = { run: now.checked ? "Checking" : held ? "Held" : "Running", halting: "Stopping", done: now.checked ? "Checked: no error" : "Done", failed: "Ended",
    store: "Storing", kept: "Kept on the board" }[now.how];
  let text = `${now.name}: ${_(how)}, `;
  if (now.stored) text += `${now.done} %${line ? ", " + _("line {line}", { line }) : ""}`;
  else text += _("line {line}, {done} of {lines}", { line, done: now.done, lines: now.lines });
  if (now.passes > 1) text += `, ${_("pass {pass} of {passes}", { pass: now.pass, passes: now.passes })}`;
  if (now.single && now.how === "run") text += `, ${_("step by step")}`;
  if (report.wait) text += `, ${_("waits {seconds} s", { seconds: report.wait.toFixed(1) })}`;
  return text;
}

function mark(line) {
  if ($("lines").dataset.line === String(line)) return;
  $("lines").dataset.line = line;
  const first = Math.max(0, line - 4);
  let now = null;
  $("lines").replaceChildren(...job.lines.slice(first, first + 9).map((text, n) => {
    const row = document.createElement(first + n + 1 === line ? "b" : "span");
    row.textContent = `${first + n + 1}  ${text}\n`;
    if (first + n + 1 === line) now = row;
    row.onclick = () => { picture.mark(first + n + 1); tellLine(first + n + 1); };
    return row;
  }));
  if (now) $("lines").scrollTop = now.offsetTop - $("lines").clientHeight / 2;
}

function showLog(message) {
  const rows = message.log.map((number) => {
    const item = document.createElement("li");
    item.textContent = `${number}: ${_(errors[number] || "")}`;
    return item;
  });
  if (message.all) return $("log").replaceChildren(...rows);
  $("log").append(...rows);
  for (const number of message.log) typed.say(errorText(number));
  $("log").scrollTop = $("log").scrollHeight;
  refuse(message.log[message.log.length - 1]);
}

function showSettings(told) {
  settings = told;
  list.show(told);
  if (nameTool(told)) { makeOverrides(order); picture.show(picture.moves); }
  show();
}

// --- jobs

function takeJobs(message) {
  if (message.jobs) {
    const before = $("jobs").value || kept("job");  // the choice is this browser's, also after a reload: none is made for it
    $("jobs").replaceChildren(new Option("–", ""), ...message.jobs.map(([name, size]) => new Option(`${name} (${Math.ceil(size / 1024)} kB)`, name)));
    $("jobs").value = message.jobs.some(([name]) => name === before) ? before : "";
    if ($("jobs").value !== job.name) load();
    queue.take(message.jobs);
  }
  return message;
}

// The text of a job, as much of it as is there.
async function textOf(name, most, wanted = () => true) {
  let text = "";
  for (let size = name ? 1 : 0; text.length < Math.min(size, most) && wanted();) {
    const piece = await link.order({ do: "job_text", name, at: text.length });
    if (piece.error || !piece.text) break;
    text += piece.text;
    size = piece.size;
  }
  return text;
}

function movesOf(text) { return cards.read(text) || read(text); }

function choose(name) {
  $("jobs").value = name;
  load();
}

async function load() {
  const name = $("jobs").value;
  const mine = { name, text: "", lines: [], language };
  job = mine;
  facts.clear();
  if (name) put("job", name);
  $("run-name").textContent = name;
  enable();
  mine.text = await textOf(name, Infinity, () => job === mine);
  if (job !== mine) return;
  job.lines = job.text.split("\n");
  $("lines").dataset.line = "";
  picture.show(movesOf(job.text));
  if (!cards.mark(null)) mark(1);
  if (name) facts.load(job);
}

async function upload(file) {
  const text = decode(await file.arrayBuffer());
  const name = unaccented(file.name).replace(/[^A-Za-z0-9 ._-]/g, "_").replace(/^[^A-Za-z0-9]+/, "").slice(-60) || "job.gcode";
  const there = (wanted) => Array.from($("jobs").options).some((option) => option.value === wanted);
  if (there(name) && !(await ask(_("Replace {name}?", { name })))) return;
  const progress = $("progress");
  for (let at = 0; at === 0 || at < text.length; at += PIECE) {
    const last = at + PIECE >= text.length;
    progress.hidden = false;
    if (last) progress.removeAttribute("value");  // a drawing becomes a job, and nobody knows how long that takes
    const answer = await order("job_part", { name, at, text: text.slice(at, at + PIECE), last });
    if (last || answer.error) progress.hidden = !report.job;
    if (answer.error) return;
    if (!last) progress.value = (at + PIECE) / text.length;
  }
  job = { name: "", text: "", lines: [] };
  await order("jobs");
  $("jobs").value = ["", ".txt", ".gcode"].map((end) => name + end).find(there) || "";  // a drawing has become a job
  await load();
}

// --- set-up

// Its script is loaded at the first look at it: what most visits do not need costs none of them time.
let loading = null;

function loadSetup() {
  if (loading) return loading;
  const sheet = document.createElement("link");
  Object.assign(sheet, { rel: "stylesheet", href: "setup.css" });
  document.head.append(sheet);
  const made = cards.can("make") ? script("setup_make.js") : Promise.resolve();
  loading = made.then(() => window.PassoSetup || script("setup.js")).then(makeSetup);  // a board's page has it already
  return loading;
}

function script(src) {
  return new Promise((loaded) => {
    const made = document.createElement("script");
    Object.assign(made, { type: "module", src, onload: loaded, onerror: () => { loading = null; made.remove(); } });
    document.head.append(made);
  });
}

function makeSetup() {
  let often = false;
  setup = new window.PassoSetup({
    order, ask, say, errorText, stop, send: (name, fields) => link.order({ do: name, ...fields }), report: () => report, axes: () => axes, settings: () => settings,
    range: () => axes && rangeOf(), can: (what) => cards.can(what), busy: () => !link.ready() || !$("card-key").hidden,
    look: (on) => { if (on !== often && jog.seldom()) link.look(on ? 50 : refresh()); often = on; },
    jog: (way, part, of) => jog.press(way, Math.max(1, speed() * part), of), letGo: (of) => jog.release(of), placed: () => tabs.show(), offsets: (list) => { picture.offsets = list; picture.draw(); }, jobs: () => Array.from($("jobs").options).map(({ value }) => value).filter(Boolean),
    chosen: async (name) => { await order("jobs"); $("jobs").value = name; await load(); tabs.choose("job"); },
  });
  return setup;
}

// --- what is pressed

function stop() {
  if (setup) setup.halt();
  shut();
  link.stop().then(refuse);
}

const speed = () => Math.max(1, Number($("jog-speed").value) || 1);
const distance = () => Number(document.querySelector("input[name=step]:checked").value);

function press(way, button) {
  const by = distance();
  if (setup && setup.locked()) return null;
  if (!by) return jog.press(way, speed(), button);
  order("step", { by: Object.fromEntries(Object.entries(way).map(([axis, sign]) => [axis, sign * by])), speed: speed() });
}

function typing(target) { return target.closest("input, select, textarea, pre, dialog"); }

// Arrows choose a distance that has the focus; chosen by finger or mouse it gives the focus back, and they move the machine.
for (const label of document.querySelectorAll("#card-jog fieldset label")) {
  for (const end of ["pointerup", "touchend"]) label.addEventListener(end, () => setTimeout(() => label.firstElementChild.blur()));
}

// Keys that are no moves.
function shortcut(key) {
  const steps = document.querySelectorAll("input[name=step]"), busy = report.state === "Run";
  if (key === "?") openDialog($("help-keys"));
  else if ("1234".includes(key) && cards.can("step")) steps[Number(key) - 1].checked = true;
  else if (key === "p" || key === "P") $(busy ? "hold" : "resume").click();
  else return false;
  return true;
}

$("help-close").onclick = shut;
// Esc stops, whatever is open and has the focus.
document.addEventListener("keydown", (event) => { if (event.key === "Escape") stop(); }, true);
document.addEventListener("keydown", (event) => {
  const plain = !event.ctrlKey && !event.altKey && !event.metaKey && !event.repeat && !typing(event.target);
  if (plain && event.key.length === 1 && shortcut(event.key)) { event.preventDefault(); return; }
  const way = KEYS[event.key];
  if (!way || typing(event.target) || event.ctrlKey || event.altKey || event.metaKey || !axes.includes(way[0]) || $("card-jog").hidden) return;
  event.preventDefault();
  if (!event.repeat) press({ [way[0]]: way[1] === "+" ? 1 : -1 }, document.querySelector(`[data-way="${way}"]`));
});
document.addEventListener("keyup", (event) => { if (KEYS[event.key]) jog.release(); });

$("stop").onclick = stop;
$("home").onclick = () => order("home");
$("unlock").onclick = () => order("unlock");
$("hold").onclick = () => order("hold");
$("resume").onclick = () => (report.job && report.job.single && report.state === "Idle" ? order("play", { what: "run" }) : order("resume"));
$("wait-go").onclick = () => order($("wait-go").dataset.order, { what: "run" });
$("pause").onclick = () => $($("pause").dataset.does).click();
$("abort").onclick = () => order("abort");
$("zero-all").onclick = async () => { if (await ask(_("Set the zero of all axes here?"))) order("zero", { axes }); };
$("give").onclick = () => order("give", { to: "guest" });
$("take").onclick = () => order("give", { to: "page" });
$("jobs").onchange = load;
$("upload").onchange = async () => { if ($("upload").files[0]) await upload($("upload").files[0]); $("upload").value = ""; };
dropped((file) => (cards.can("jobs") ? upload(file) : shelf.upload(file)), () => cards.can("jobs") || cards.can("kept"));
$("remove").onclick = async () => {
  const name = $("jobs").value;
  if (name && await ask(_("Remove {name}?", { name }))) { await order("job_remove", { name }); await order("jobs"); }
};
async function run(fields) {
  starting = true;
  $("job-state").textContent = "";
  await order("run", fields);
  starting = false;
}
$("run").onclick = async () => {
  const name = $("jobs").value;
  const shown = job.name === name && job.lines.length > 0;
  if (shown || await ask(_("Run {name}, which is not shown here yet?", { name }))) run({ name, passes: Number($("passes").value) || 1 });
};
$("check").onclick = () => run({ name: $("jobs").value, check: true });
// The corners of the job's box, one after the other, at the height where the tool is. It ends if any page presses STOP, or if the tool does not reach a corner.
$("round").onclick = async () => {
  const [[left, right], [low, high]] = picture.bounds(), before = stops(), size = { width: (right - left).toFixed(1), height: (high - low).toFixed(1) };
  const height = axes.includes("z") ? _("It stays at the height where it is now.") : "";
  if (!(await ask(`${_("The tool goes around the job, {width} × {height} mm. Is the way free?", size)} ${height}`.trim()))) return;
  for (const [x, y] of [[left, low], [right, low], [right, high], [left, high], [left, low]]) {
    if (stops() !== before || (await order("goto", { to: { x, y }, speed: speed() })).error || !(await atRest())) return;
    if (Math.hypot(report.w[0] - x, report.w[1] - y) > NEAR_MM) return;
  }
};
$("key-form").onsubmit = (event) => {
  event.preventDefault();
  storeKey($("key").value);
  useKey();
};
$("goto-form").onsubmit = (event) => {
  event.preventDefault();
  const to = Object.fromEntries([...axes].filter((axis) => $(`goto-${axis}`).value !== "").map((axis) => [axis, Number($(`goto-${axis}`).value)]));
  order("goto", { to, speed: speed() });
};
$("path-in").onclick = () => picture.zoom(1.3);
$("path-out").onclick = () => picture.zoom(1 / 1.3);
$("path-fit").onclick = () => picture.fit();
$("path-solid").onclick = () => {
  const solid = $("path-solid").getAttribute("aria-pressed") !== "true";
  $("path-solid").setAttribute("aria-pressed", solid);
  picture.stand(solid);
};
$("path-shade").onchange = () => { picture.shade = $("path-shade").value; picture.draw(); };
for (const button of document.querySelectorAll("[data-output]")) {
  button.onclick = () => order("output", { name: button.dataset.output, rpm: Number($("rpm").value) || 0 });
}
switchWork(order, ask);
$("teach-begin").onclick = () => order("teach", { what: "begin" });
$("teach-drop").onclick = () => order("teach", { what: "drop" });
$("teach-save").onclick = async () => {
  const name = $("teach-name").value;
  if ((await order("teach", { what: "save", name })).error) return;
  job = { name: "", text: "", lines: [] };
  await order("jobs");
  $("jobs").value = name;
  load();
};
$("machine").onclick = async () => {
  const name = $("machines").value;
  if (name && await ask(_("Restart as {name}?", { name }))) order("machine", { name });
};

// --- how it looks

// Milliseconds between reports; 0: only changes.
function refresh() { return Number($("refresh").value); }

function storeKey(text) {
  link.key = text.toUpperCase().replace(/[^A-Z0-9]/g, "");
  try { sessionStorage.setItem("key", link.key); } catch { /* a page without storage asks again */ }
}

function kept(name) { try { return localStorage.getItem(name); } catch { return null; } }

function put(name, value) { try { localStorage.setItem(name, value); } catch { /* it is as before, the next time */ } }

function theme(name) {
  const dark = name === "dark" || (name === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  picture.draw();
}

async function speak(language) {
  await chooseWords(language);
  nameTool(settings);
  makeOverrides(order);
  const now = axes;
  axes = "";
  setAxes(now, turns);
  if (setup) setup.speak();
  for (const card of [prove, board]) if (card) card.speak();
  showTitles(true);
  cards.tellElsewhere();
  facts.tell();
  picture.draw();
  if (alarmText && $("message").textContent === alarmText) say("");  // show() says it in the other language
  show();
  if (link.key && link.ready()) { link.order({ do: "settings" }); link.order({ do: "log" }); }
}

$("language").onchange = () => { put("language", $("language").value); speak($("language").value); };
$("theme").onchange = () => { put("theme", $("theme").value); theme($("theme").value); };
matchMedia("(prefers-color-scheme: dark)").onchange = () => theme($("theme").value);
$("refresh").onchange = () => { put("refresh", $("refresh").value); link.look(refresh()); };

const given = /[#&]key=([A-Za-z0-9-]+)/.exec(location.hash);
if (given) {
  storeKey(given[1]);
  history.replaceState(null, "", location.pathname + location.search);
} else {
  try { link.key = sessionStorage.getItem("key") || ""; } catch { /* asked for */ }
}
const asked = new URLSearchParams(location.search);
$("language").value = [asked.get("lang"), kept("language"), preferred()].find((each) => languages.includes(each));
$("theme").value = [asked.get("theme"), kept("theme")].find((each) => ["auto", "light", "dark"].includes(each)) || "auto";
$("refresh").value = [kept("refresh"), "50"].find((each) => [...$("refresh").options].some((option) => option.value === each));
theme($("theme").value);
explain(sentences);
table("errors.json").then((found) => { errors = found; return speak($("language").value); });
