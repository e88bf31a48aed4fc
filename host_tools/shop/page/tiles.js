// What both pages of the shop show: elements, and the states of machines in words.

export function element(kind, name, text = "") {
  const made = document.createElement(kind);
  if (name) made.className = name;
  made.textContent = text;
  return made;
}

// What an agent or the shop has said, in the language of the page.
export const said = (text) => (text ? text[document.documentElement.lang] || text.en : "");

export const states = {
  idle: "at rest", run: "moves", hold: "held", jog: "is moved by hand", home: "finds its zero", door: "door open", alarm: "in alarm", check: "checks",
  sleep: "asleep", lost: "the board does not answer", gone: "not reached",
};
