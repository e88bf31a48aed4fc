// The page on the machine's own PC: "paper is in", go on, give up.

import { _, choose, preferred } from "./words.js";
import { element, said, states } from "./tiles.js";

const answered = document.getElementById("said");
const main = document.getElementById("machines");
const HOW = {
  rest: "Nobody has released this machine.", free: "Released: it takes the next job that fits.", fetch: "The job's file comes.",
  run: "It draws.", waits: "It waits for you.", goes: "It gets ready.",
};
let shown = "";

async function order(name, what) {
  const answer = await fetch("/do", { method: "POST", body: JSON.stringify({ name, do: what }) });
  answered.textContent = said((await answer.json()).text);
  shown = "";
}

function button(text, machine, what, kind) {
  const made = element("button", kind, _(text));
  made.addEventListener("click", () => order(machine.name, what));
  return made;
}

function tile(machine) {
  const made = element("article", `tile how-${machine.how}`);
  made.append(element("h2", "", machine.name), element("p", "state", states[machine.state] ? _(states[machine.state]) : _("not heard of yet")), element("p", "how", _(HOW[machine.how])));
  if (machine.file) made.append(element("p", "file", !machine.progress ? machine.file : `${machine.file} · ${machine.progress} %`));
  if (machine.how === "waits" && machine.line) made.append(element("p", "", _("It stopped behind line {line}.", { line: machine.line })));
  if (machine.text) made.append(element("p", "why", said(machine.text)));
  if (machine.alarm) made.append(element("p", "why", said(machine.alarm)));
  if (machine.how === "rest" && machine.ended) made.append(element("p", "", _(machine.ended[1] === "done" ? "The last job is done: take it out." : "The last job was not done.")));
  if (machine.how === "rest") made.append(button("Paper is in", machine, "release", "go"));
  if (machine.how === "free" || machine.how === "fetch") made.append(button("Take it back", machine, "withdraw", ""));
  if (machine.how === "waits") made.append(button(machine.down ? "The tool may go down" : "Go on", machine, "go", "go"), button("Give the job up", machine, "give up", ""));
  return made;
}

async function look() {
  try {
    const machines = await (await fetch("/machines")).json();
    const text = JSON.stringify(machines.map((each) => ({ ...each, place: "", counters: "", left: "" })));
    if (text !== shown) main.replaceChildren(...machines.map(tile));
    shown = text;
  } catch (error) {
    shown = "";
    main.replaceChildren(element("p", "why", _("The agent does not answer.")));
  }
  setTimeout(look, 500);
}

const language = document.getElementById("language");
language.addEventListener("change", async () => { await choose(language.value); shown = ""; });
language.value = preferred();
choose(language.value).then(look);
