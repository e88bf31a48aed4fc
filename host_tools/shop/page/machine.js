// The page on the machine's own PC: "paper is in", go on, give up.

import { _, choose, preferred } from "./words.js";
import { explain, showTitles } from "./titles.js";
import { hex, hmac } from "./sha256.js";
import { element, said, states } from "./tiles.js";

const at = (id) => document.getElementById(id);
const bytes = (text) => new TextEncoder().encode(text);
const main = at("machines");
const HOW = {
  rest: "Nobody has released this machine.", free: "Released: it takes the next job that fits.", fetch: "The job's file comes.",
  run: "It draws.", waits: "It waits for you.", goes: "It gets ready.",
};
const KEY = "passo-machine-key";
let shown = "";
let key = "", nonce = "", count = 0;

// What an answer tells of proofs: a new nonce after each start of the agent, and the last count, which another tab may have taken.
function heads(answer) {
  const fresh = answer.headers.get("X-Passo-Nonce");
  count = Math.max(fresh === nonce ? count : 0, Number(answer.headers.get("X-Passo-Count") || 0));
  nonce = fresh;
  return answer;
}

// An order with its proof; the key is never sent.
async function post(body) {
  count++;
  const proof = hex(hmac(bytes(key), bytes(`${nonce}.${count}.POST /do ${body}`)));
  return heads(await fetch("/do", { method: "POST", body, headers: key ? { "X-Passo": `${count}.${proof}` } : {} }));
}

async function order(name, what) {
  const body = JSON.stringify({ name, do: what }), before = nonce, counted = count;
  let answer = await post(body);
  if (answer.status === 403 && key && (nonce !== before || count > counted + 1)) answer = await post(body);  // the agent or another tab was ahead
  at("said").textContent = said((await answer.json()).text);
  if (answer.status === 403) useKey("");
  shown = "";
}

// All machines of this agent, or one. It says what did not arrive.
async function stop(name = "") {
  const text = await fetch("/do", { method: "POST", body: JSON.stringify({ name, do: "stop" }) }).then((answer) => answer.json()).then((answer) => said(answer.text))
    .catch(() => _("STOP was not sent. Use the emergency stops."));
  at("said").textContent = text || _("STOP has been sent. Look at the machine.");
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
  if (machine.how === "run" || machine.how === "goes") {
    const halt = element("button", "danger", _("STOP"));
    halt.addEventListener("click", () => stop(machine.name));
    made.append(halt);
  }
  if (machine.how === "rest") made.append(button("Paper is in", machine, "release", "go"));
  if (machine.how === "free" || machine.how === "fetch") made.append(button("Take it back", machine, "withdraw", ""));
  if (machine.how === "waits") made.append(button(machine.down ? "The tool may go down" : "Go on", machine, "go", "go"), button("Give the job up", machine, "give up", ""));
  return made;
}

async function look() {
  try {
    const machines = await heads(await fetch("/machines")).json();
    const text = JSON.stringify(machines.map((each) => ({ ...each, place: "", counters: "", left: "" })));
    if (text !== shown) main.replaceChildren(...machines.map(tile));
    shown = text;
  } catch (error) {
    shown = "";
    main.replaceChildren(element("p", "why", _("The agent does not answer.")));
  }
  setTimeout(look, 500);
}

function useKey(text) {
  key = text.toUpperCase().replace(/[^A-Z2-9]/g, "");
  sessionStorage.setItem(KEY, key);
  at("open").hidden = Boolean(key);
}

at("open").addEventListener("submit", (event) => { event.preventDefault(); useKey(at("key").value); at("key").value = ""; });
at("stop").addEventListener("click", () => stop());
document.addEventListener("keydown", (event) => { if (event.key === "Escape" && !event.repeat) stop(); }, true);
const given = /key=([A-Z2-9]+)/.exec(location.hash);
if (given) history.replaceState(null, "", location.pathname);
useKey(given ? given[1] : sessionStorage.getItem(KEY) || "");
const language = at("language");
language.addEventListener("change", async () => { await choose(language.value); showTitles(true); shown = ""; });
language.value = preferred();
choose(language.value).then(() => { showTitles(true); look(); });

explain(() => [
  ["#language", _("Language of this page")],
  ["#stop", _("Stops the machines of this computer at once")],
  ["#key", _("The letters that the agent has printed in its terminal")],
  ["form button", _("Lets this page release the machines")],
  [".danger", _("Stops this machine at once, and drops its job")],
  ["button", _("Tells the shop that somebody at the machine wants this")],
]);
