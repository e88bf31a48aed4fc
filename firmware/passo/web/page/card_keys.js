// The kit of two motors: on, off, reverse and speed of each.

import { grey } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const SLOWEST = 127;

export class Keys {
  constructor(page) {
    this.page = page;
    this.made = "";
    for (const button of document.querySelectorAll("[data-motor]")) this.act(button);
  }

  act(button) {
    const [motor, what] = button.dataset.motor.split(" ");
    button.onclick = () => this.page.order("motor", { motor: Number(motor), what, ...(what === "speed" ? { speed: Number($(`speed-${motor}`).value) } : {}) });
  }

  make() {
    this.made = document.documentElement.lang;
    $("motors").replaceChildren(...[1, 2].map((motor) => {
      const row = document.createElement("fieldset");
      row.innerHTML = `<legend></legend><p id="motor-${motor}" role="status"></p><p class="row fill"></p>
        <p class="row fill"><label class="line"><span></span><input id="speed-${motor}" type="number" min="1" max="${SLOWEST}" value="1" inputmode="numeric"></label></p>`;
      row.querySelector("legend").textContent = _("Motor {motor}", { motor });
      row.querySelector("label span").textContent = _("Speed, 1 (fastest) … {slowest}", { slowest: SLOWEST });
      [["on", _("On")], ["off", _("Off")], ["reverse", _("Reverse")], ["speed", _("Set the speed")]].forEach(([what, name]) => {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = name;
        button.dataset.motor = `${motor} ${what}`;
        button.setAttribute("aria-label", `${name}: ${_("Motor {motor}", { motor })}`);
        this.act(button);
        row.querySelectorAll("p.row")[what === "speed" ? 1 : 0].append(button);
      });
      return row;
    }));
  }

  show(report, why) {
    if (this.made !== document.documentElement.lang) this.make();
    (report.motors || []).forEach((motor, n) => {
      const text = motor.on ? `${motor.back ? _("anticlockwise") : _("clockwise")}, ${_("{rate} steps/s", { rate: motor.rate })}` : _("off");
      if ($(`motor-${n + 1}`).textContent !== text) $(`motor-${n + 1}`).textContent = text;
    });
    for (const button of document.querySelectorAll("[data-motor]")) grey(button, report.link ? "" : why.rest);
  }
}
