// The buttons that move the machine: pressed by a finger, a mouse or a key.

import { held } from "./old.js";
import { _ } from "./words.js";

const CELLS = [
  [{ x: -1, y: 1 }, "↖"], [{ y: 1 }, "↑"], [{ x: 1, y: 1 }, "↗"], [{ z: 1 }, "▲"], [{ a: 1 }, "↻"],
  [{ x: -1 }, "←"], null, [{ x: 1 }, "→"], null, null,
  [{ x: -1, y: -1 }, "↙"], [{ y: -1 }, "↓"], [{ x: 1, y: -1 }, "↘"], [{ z: -1 }, "▼"], [{ a: -1 }, "↺"],
];

const STRAIGHT = { "↻": "▲", "↺": "▼" };  // an A that does not turn

const nameOf = (way) => Object.entries(way).map(([axis, part]) => axis + (part > 0 ? "+" : "-")).join("");

function button(way, sign, unit, press, release) {
  const made = document.createElement("button");
  const name = nameOf(way);
  made.type = "button";
  made.dataset.way = name;
  made.innerHTML = "<span></span><small></small>";
  made.firstChild.textContent = sign;
  made.lastChild.textContent = name.toUpperCase().replace(/-/g, "−") + unit;
  made.setAttribute("aria-label", `${_("Move")} ${made.lastChild.textContent}`);
  held(made, () => press(way, made), () => release(made));
  made.addEventListener("blur", () => release(made));
  made.onkeydown = (event) => { if ([" ", "Enter"].includes(event.key)) { event.preventDefault(); if (!event.repeat) press(way, made); } };
  made.onkeyup = () => release(made);
  return made;
}

// Fill `root`: for the axes of a machine, `turns` those that count degrees, and two at once if it can; press(way, button), release(button).
export function makePad(root, axes, turns, diagonal, press, release) {
  const columns = axes.includes("a") ? 5 : axes.includes("z") ? 4 : 3;
  root.dataset.columns = columns;
  root.replaceChildren(...CELLS.filter((cell, n) => n % 5 < columns).map((cell) => {
    const ways = cell ? Object.keys(cell[0]) : [];
    if (!cell || !ways.every((axis) => axes.includes(axis)) || ways.length > 1 && !diagonal) return document.createElement("span");
    const round = turns.includes(ways[0]);
    return button(cell[0], round ? cell[1] : STRAIGHT[cell[1]] || cell[1], round ? " °" : "", press, release);
  }));
}
