// Overrides, outputs, and the bar that says what the program waits for.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
let laser = false;  // $32: what turns at a spindle is the power of a laser
const OVERRIDES = [["feed", "Feed", ["-10", "+10", "100"]], ["rapid", "Rapid", ["25", "50", "100"]], ["spindle", "Spindle", ["-10", "+10", "100"]]];

export const isLaser = () => laser;
export const toolName = () => (laser ? _("Laser") : _("Spindle"));

// The words of the tool's card, by the settings; a laser begins with a twentieth of its power. True if they are others than before.
export function nameTool(settings) {
  const before = laser, most = Number(settings[30]) || 0;
  laser = Number(settings[32]) === 1;
  const words = laser ? { unit: _("S, of {most}", { most }), short: "S", cw: _("On (M3)"), ccw: _("By speed (M4)") }
    : { unit: _("rpm"), short: _("rpm"), cw: _("On"), ccw: _("Reversed") };
  for (const place of document.querySelectorAll("[data-tool]")) place.textContent = { ...words, name: toolName() }[place.dataset.tool];
  if (laser && Number($("rpm").value) > most) $("rpm").value = Math.round(most / 20);
  return laser !== before;
}

// A row for each override: its name, its buttons, its value. order(name, fields).
export function makeOverrides(order) {
  $("overrides").replaceChildren(...OVERRIDES.map(([what, name, steps]) => {
    const row = document.createElement("div");
    row.className = "override";
    row.innerHTML = "<span></span>";
    row.firstChild.textContent = what === "spindle" ? toolName() : _(name);
    for (const to of steps) row.append(overrideButton(what, name, to, order));
    const value = document.createElement("output");
    value.id = `ov-${what}`;
    value.textContent = "100 %";
    row.append(value);
    return row;
  }));
}

function overrideButton(what, name, to, order) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = `${to.replace("-", "−")} %`;
  button.dataset.override = what + to;
  button.setAttribute("aria-label", `${what === "spindle" ? toolName() : _(name)} ${button.textContent}`);
  button.onclick = () => order("override", { what, to });
  return button;
}

function pressed(button, on) { if (!button) return; if (button.getAttribute("aria-pressed") !== String(on)) button.setAttribute("aria-pressed", on); }

// What is on looks on.
export function showControls(report) {
  (report.ov || []).forEach((value, n) => {
    const what = OVERRIDES[n][0], text = `${value} %`, place = $(`ov-${what}`);
    if (place && place.textContent !== text) place.textContent = text;
    if (what === "rapid") for (const to of OVERRIDES[n][2]) pressed(document.querySelector(`[data-override="rapid${to}"]`), Number(to) === value);
  });
  for (const button of document.querySelectorAll("[data-on]")) pressed(button, (report.on || "").includes(button.dataset.on));
  showWork(report);
  for (const button of document.querySelectorAll("[data-switch]")) {
    const [what, way] = button.dataset.switch.split("_"), name = what === "motors" ? "ours" : what;
    if (way === "on" && name in report) pressed(button, Boolean(report[name]));
  }
}

// The vacuum cleaner and the clamp, of machines that have them: as the status says, "1" on, "0" off, "0P1" under M64 P1. Beside a clamp M10
// is the clamp's: a cleaner without a number of its own has no button then.
const valueOf = (report, word) => ((report.more || []).find(([name]) => name === word) || [])[1];
function showWork(report) {
  if (report.more === undefined) return;
  const buttons = [...document.querySelectorAll("[data-work]")];
  for (const button of buttons) {
    const value = valueOf(report, button.dataset.work);
    if (value) button.dataset.value = value;  // a long report leaves words out
    pressed(button, (button.dataset.value || "")[0] === "1");
  }
  const clamped = buttons.some((button) => button.dataset.work === "Clamp" && button.dataset.value);
  for (const button of buttons) {
    const { work, value } = button.dataset;
    button.hidden = !value || (clamped && work === "Vac" && !value.includes("P"));
  }
  $("work").hidden = buttons.every((button) => button.hidden);
}

// order(name, fields), ask(text): letting go of the work is asked for.
export function switchWork(order, ask) {
  for (const button of document.querySelectorAll("[data-work]")) {
    button.onclick = async () => {
      const [now, number] = button.dataset.value.split("P"), on = now[0] !== "1";
      if (!on && button.dataset.work === "Clamp" && !(await ask(_("Let go of the workpiece?")))) return;
      order("line", { line: number ? `M${on ? 64 : 65} P${number}` : on ? "M10" : "M11" });
    };
  }
}

// M0 and M6: what there is to do, and what the button says that goes on; null: nothing.
function paused(report) {
  const why = report.state === "Hold" && report.sub === "0" ? report.why : "";
  if (!why) return null;
  if (why === "pause") return [_("The program has paused (M0). Do what it waits for, then go on."), _("Go on")];
  return [_("Put in tool {tool}. Keep your hands away, then go on.", { tool: why }), _("Tool {tool} is in: go on", { tool: why })];
}

// "on" or "off", in words that agree with the name of what is so: in Portuguese a door is not on as a spindle is.
const AGREES = { Door: "f.", Coolant: "f.", Mist: "f.", tool: "f.", drives: "pl.", ours: "pl." };
export function onOff(name, on) {
  const [plain, feminine, plural] = on ? [_("on"), _("on (f.)"), _("on (pl.)")] : [_("off"), _("off (f.)"), _("off (pl.)")];
  return ({ "f.": feminine, "pl.": plural }[AGREES[name]] || plain).split(" (")[0];
}

// Greys a button, and says why to a pointer and to a screen reader; "": it may be pressed.
export function grey(button, why) {
  button.disabled = Boolean(why);
  if ((button.dataset.why || "") !== why) button.dataset.why = why;
  const title = why || button.dataset.help || "";
  if (button.title !== title) button.title = title;
}

// Why nothing may begin now, in words; "" where it may. `mine`: this page commands; `rest`: the machine is at rest, perhaps in an alarm; `idle`: and
// in none.
export function reasons(report, busy) {
  const mine = report.owner === "guest" ? _("Another program moves the machine.") : "";
  let rest = "";
  if (report.link === false || !report.state) rest = _("There is no link to the machine.");
  else if (busy) rest = _("A job is under way.");
  else if (["Hold", "Door"].includes(report.state)) rest = _("The machine is held: resume it first.");
  else if (!["Idle", "Alarm"].includes(report.state)) rest = _("The machine is not at rest.");
  return { mine, rest, idle: rest || (report.state === "Alarm" ? _("The machine is locked: home or unlock it first.") : ""),
    chosen: $("jobs").value ? "" : _("Choose a file first.") };
}

// What a job waits for, or else the queue.
export function showWait(report, mine, queued) {
  const told = paused(report) || queued;
  $("wait-bar").hidden = !told;
  if (!told) $("wait-text").textContent = $("wait-go").textContent = "";
  if (!told) return;
  $("wait-go").dataset.order = told === queued ? "queue" : "resume";
  const [text, go] = told;
  if ($("wait-text").textContent !== text) $("wait-text").textContent = text;
  if ($("wait-go").textContent !== go) $("wait-go").textContent = go;
  $("wait-go").disabled = !mine;
}
