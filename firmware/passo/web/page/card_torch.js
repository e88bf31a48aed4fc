// The torch: moves of each axis at its own speed, seams, the origin, and the preferences of jogs.

import { grey } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const PREFERENCES = ["jogx", "jogy", "xv", "yv", "sx", "sy"];

// The numbers of a form's fields that are filled in.
const numbers = (form, names) => Object.fromEntries(names.filter((name) => form.elements[name].value !== "").map((name) => [name, Number(form.elements[name].value)]));

export class Torch {
  constructor(page) {
    this.page = page;
    this.asked = false;
    $("origin").onclick = async () => { if (await page.ask(_("Make this place the origin?"))) page.order("origin"); };
    this.form("move-form", (form) => {
      const { x, y, xv, yv } = numbers(form, ["x", "y", "xv", "yv"]);
      page.order("move", { by: { x, y }, xv, yv });
    });
    this.form("weave-form", (form) => {
      const { x, y, cx, cy, ...seam } = numbers(form, ["x", "y", "cx", "cy", "amplitude", "pitch", "speed", "left", "right"]);
      const { shape, clockwise, along } = form.elements;
      const arc = cx || cy ? { centre: { x: cx || 0, y: cy || 0 }, clockwise: clockwise.checked } : {};
      page.order("weave", { shape: shape.value, to: { x, y }, along: along.checked, ...arc, ...seam });
    });
    this.form("preferences-form", async (form) => {
      if (await page.ask(_("Save these preferences in place of those that the board keeps?")) && !(await page.order("configure", numbers(form, PREFERENCES))).error) this.tell();
    });
  }

  form(name, action) { $(name).onsubmit = (event) => { event.preventDefault(); action(event.target); }; }

  // The preferences as the board keeps them.
  async tell() {
    const told = await this.page.order("preferences");
    if (told.error) { this.asked = false; return; }
    const fields = $("preferences-form").elements;
    PREFERENCES.forEach((name, n) => { fields[name].value = [...told.jog, ...told.speed, ...told.scale][n]; });
  }

  show(report, why) {
    if (!this.asked && this.page.proven()) {
      this.asked = true;
      this.tell();
    }
    for (const name of ["move-form", "weave-form", "preferences-form"]) grey($(name).querySelector("button"), why.idle);
    grey($("origin"), why.idle);
    if ($("dropped").textContent !== String(report.dropped || 0)) $("dropped").textContent = report.dropped || 0;
  }
}
