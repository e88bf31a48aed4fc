// The machine of this tab, in a Web Worker: its turns never hold up the page.
//
// In: {start: board} once, then texts: orders as the page's link sends them. Out: texts, as a server would push them; {fault: text}
// if Python gives up.

import { load } from "./firmware.js";

const TURN_MS = 12;

const waiting = [];
let begun = false;

onmessage = (event) => {
  if (begun || typeof event.data === "string") waiting.push(event.data);
  else { begun = true; run(event.data.start).catch((error) => postMessage({ fault: String(error) })); }
};

async function run(board) {
  const [texts, site] = await Promise.all(["firmware.json", "site.json"].map(async (name) => (await fetch(name)).json()));
  const python = await load(texts, (line) => console.log(line));
  python.registerJsModule("page", { send: (text) => postMessage(text) });
  python.globals.set("chosen", board);
  python.globals.set("jobs_text", JSON.stringify(site.boards[board]));
  python.globals.set("boards_text", JSON.stringify(Object.keys(site.boards)));
  python.runPython("import json, page\nfrom host_tools.sim.tab import Tab\n"
    + "tab = Tab(chosen, json.loads(jobs_text), page.send, json.loads(boards_text))\nturn, hear = tab.turn, tab.hear");
  const turn = python.globals.get("turn"), hear = python.globals.get("hear");
  const again = new MessageChannel();  // without the 4 ms that a browser adds to timers
  const next = () => {
    try {
      while (waiting.length) hear(waiting.shift());
      const pause = turn(TURN_MS);
      if (pause) setTimeout(next, pause); else again.port2.postMessage(0);
    } catch (error) {
      postMessage({ fault: String(error) });
    }
  };
  again.port1.onmessage = next;
  next();
}
