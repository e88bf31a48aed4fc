// The torch's small page: without it the forms work by themselves for who is admitted; with it they prove the key, and the
// position is pushed. The key stays in this tab: what is sent is a proof of it (passo/web/guard.py).
import { hex, hmac } from "/sha256.js";

const JOG_MS = 60; // between two requests while a button is held; the board goes on for 100 ms
const answer = document.getElementById("answer");
const place = document.getElementById("place");
const key = document.getElementById("key");
const bytes = (text) => new TextEncoder().encode(text);
const letters = (text) => text.toUpperCase().replace(/[^A-HJ-NP-Z2-9]/g, "");
let nonce = null, count = 0, line = Promise.resolve();
let stops = 0; // how often STOP was pressed: what was asked before it is not asked again, nor later

const english = !(navigator.language || "pt").toLowerCase().startsWith("pt");
if (english) {
  document.querySelector("main").lang = "en";
  for (const each of document.querySelectorAll("[data-en]")) each.textContent = each.dataset.en;
}
// What each control does, by its form's path and its name: [Portuguese, English].
const DOES = {
  "/HALT": ["Para a tocha na hora", "Stops the torch at once"],
  "/JOGX+": ["Move X para mais enquanto apertado", "Moves X to plus while it is held"], "/JOGX-": ["Move X para menos enquanto apertado", "Moves X to minus while it is held"],
  "/JOGY+": ["Move Y para mais enquanto apertado", "Moves Y to plus while it is held"], "/JOGY-": ["Move Y para menos enquanto apertado", "Moves Y to minus while it is held"],
  "/ON": ["Os relés ligam os motores a esta placa", "Relays connect the motors to this board"],
  "/OFF": ["Os relés devolvem os motores ao controle original", "Relays give the motors back to the original controller"],
  "/ORIGIN": ["Este lugar vira a origem 0;0", "This place becomes the origin 0;0"], "/INFO": ["Pergunta a posição", "Asks for the position"],
  "/COMMAND": ["Move cada eixo tantos passos, na sua velocidade", "Moves each axis by its steps, at its own speed"],
  "/CONFIG": ["Passos e velocidades dos movimentos manuais", "Steps and speeds of moves by hand"],
  key: ["As letras que passo wifi mostra", "The letters that passo wifi shows"],
};
for (const each of document.querySelectorAll("button, input")) {
  const path = each.form && each.form.getAttribute("action");
  each.title = (DOES[path] || DOES.key)[english ? 1 : 0];
}
key.value = new URLSearchParams(location.hash.slice(1)).get("key") || sessionStorage.getItem("key") || "";
key.addEventListener("input", () => sessionStorage.setItem("key", key.value));
history.replaceState(null, "", "/");

async function once(method, path, body) {
  const headers = { Accept: "application/json" };
  const secret = letters(key.value);
  if (method === "POST" && secret && nonce) {
    count++;
    headers["X-Passo"] = `${count}.${hex(hmac(bytes(secret), bytes(`${nonce}.${count}.${method} ${path} ${body}`)))}`;
  }
  const got = await fetch(path, { method, headers, body: method === "POST" ? body : undefined });
  const fresh = got.headers.get("X-Passo-Nonce");
  const stale = fresh !== nonce;
  nonce = fresh;
  count = Math.max(stale ? 0 : count, Number(got.headers.get("X-Passo-Count") || 0));
  return { said: got.ok ? await got.json() : { error: got.status, state: await got.text() }, stale };
}

async function send(method, path, body = "") {
  const before = stops;
  let { said } = await once(method, path, body);
  if (said.error === 178 && letters(key.value) && stops === before) ({ said } = await once(method, path, body)); // another page has counted on
  show(said);
  return said;
}

function show(said) {
  answer.textContent = Object.entries(said).map((pair) => pair.join("=")).join("&");
  answer.className = said.error ? "bad" : "";
  if (said.error === 178) key.focus();
  at(said);
}

function at(said) {
  if (!said.spmx) return;
  const mm = (steps, perMetre) => ((steps * 1000) / perMetre).toFixed(2);
  place.textContent = `X ${mm(said.px, said.spmx)}  Y ${mm(said.py, said.spmy)} mm`;
}

const failed = (error) => show({ error: "-", state: String(error) });

for (const form of document.querySelectorAll("form[action]")) {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const fields = [...new FormData(form)].map((pair) => pair.join("=")).join("&");
    const method = form.method.toUpperCase();
    if (form.querySelector("#halt")) stops++;
    const before = stops;
    const go = () => stops === before && send(method, form.getAttribute("action"), fields).catch(failed);
    if (form.querySelector("#halt")) go(); // never behind another
    else if (!form.querySelector("[data-jog]")) line = line.then(go);
  });
}

document.addEventListener("keydown", (event) => { if (event.key === "Escape" && !event.repeat) document.getElementById("halt").click(); }, true);

for (const button of document.querySelectorAll("[data-jog]")) {
  const path = button.form.getAttribute("action");
  let held = false;
  const hold = async () => {
    if (held) return;
    held = true;
    const before = stops;
    while (held && stops === before) {
      const said = await send("POST", path).catch(failed);
      if (!said || said.error) break;
      await new Promise((done) => setTimeout(done, JOG_MS));
    }
    held = false;
  };
  const release = () => { held = false; };
  button.addEventListener("pointerdown", hold);
  button.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") hold(); });
  for (const end of ["pointerup", "pointercancel", "pointerleave", "keyup", "blur"]) button.addEventListener(end, release);
  window.addEventListener("blur", release);
}

const events = new EventSource("/EVENTS");
events.onmessage = (event) => at(JSON.parse(event.data));
send("GET", "/INFO").catch(failed);
