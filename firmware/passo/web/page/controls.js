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
  for (const button of document.querySelectorAll("[data-switch]")) {
    const [what, way] = button.dataset.switch.split("_"), name = what === "motors" ? "ours" : what;
    if (way === "on" && name in report) pressed(button, Boolean(report[name]));
  }
}

// M0 and M6: what there is to do, and what the button says that goes on; null: nothing.
function paused(report) {
  const why = report.state === "Hold" && report.sub === "0" ? report.why : "";
  if (!why) return null;
  if (why === "pause") return [_("The program has paused (M0). Do what it waits for, then go on."), _("Go on")];
  return [_("Put in tool {tool}. Keep your hands away, then go on.", { tool: why }), _("Tool {tool} is in: go on", { tool: why })];
}

// What a job waits for, or else the queue.
export function showWait(report, mine, queued) {
  const told = paused(report) || queued;
  $("wait-bar").hidden = !told;
  if (!told) return;
  $("wait-go").dataset.order = told === queued ? "queue" : "resume";
  const [text, go] = told;
  if ($("wait-text").textContent !== text) $("wait-text").textContent = text;
  if ($("wait-go").textContent !== go) $("wait-go").textContent = go;
  $("wait-go").disabled = !mine;
}
