// Pieces that the parts of the set-up are built of.

import { _ } from "./words.js";

// An element with properties; "on…" and the like are set, names with a dash are attributes.
export function make(tag, about = {}, ...children) {
  const made = document.createElement(tag);
  for (const name of Object.keys(about)) if (name.includes("-") || name === "role" || name === "for") made.setAttribute(name, about[name]); else made[name] = about[name];
  made.append(...children.filter((each) => each !== null));
  return made;
}

export const button = (text, onclick, className = "") => make("button", { type: "button", textContent: text, onclick, className });
export const note = (text) => make("p", { className: "note", textContent: text });

export function setText(node, text) { if (node.textContent !== text) node.textContent = text; }

export function stored(name, otherwise) {
  try { return { ...otherwise, ...JSON.parse(localStorage.getItem(name)) }; } catch (error) { return { ...otherwise }; }
}

export function store(name, value) {
  try { localStorage.setItem(name, JSON.stringify(value)); } catch (error) { /* it is as before, the next time */ }
}

// Fields of numbers and choices that this browser remembers. fields: [{name, label, value, min, max, step} or {name, label, value, options: [[value, text]]}]
export class Fields {
  constructor(key, fields, changed) {
    this.key = `setup-${key}`;
    this.fields = fields;
    const before = stored(this.key, {});
    this.inputs = {};
    this.node = make("div", { className: "pairs" });
    this.more = make("div", { className: "pairs" });  // what is seldom changed
    for (const field of fields) {
      const input = field.options ? make("select", {}, ...field.options.map(([value, text]) => new Option(text, value)))
        : make("input", { type: "number", step: "any", min: field.min, max: field.max, required: true, inputMode: "decimal" });
      input.id = `${this.key}-${field.name}`;
      input.value = field.name in before ? before[field.name] : field.value;
      if (!input.value) input.value = field.value;
      input.onchange = () => { store(this.key, this.raw()); changed(); };
      this.inputs[field.name] = input;
      (field.more ? this.more : this.node).append(make("label", {}, make("span", { textContent: field.label }), input));
    }
  }

  raw() {
    const found = {};
    for (const { name } of this.fields) found[name] = this.inputs[name].value;
    return found;
  }

  // {name: value}, or null if one of them is out of its bounds.
  values() {
    const found = {};
    for (const field of this.fields) {
      const input = this.inputs[field.name];
      if (!field.options && !input.checkValidity()) return null;
      found[field.name] = field.options ? input.value : Number(input.value);
    }
    return found;
  }

  // Why the values are refused, "" if they are not.
  wrong() {
    const field = this.fields.find(({ name, options }) => !options && !this.inputs[name].checkValidity());
    return field ? _("{name}: from {least} to {most}.", { name: field.label, least: field.min, most: field.max }) : "";
  }
}
