// Drives a CNCjs server as its page does: node cncjs_sender.js FOLDER PORT, with the FOLDER in which `npm install cncjs` was done. Each line of stdin is
// a JSON array, an event and its arguments; each event of the server is such a line of stdout. "connect" is the first.

const { createRequire } = require("node:module");
const [folder, port] = process.argv.slice(2);
const io = createRequire(`${folder}/node_modules/cncjs/`)("socket.io-client");
const EVENTS = ["connect", "serialport:open", "serialport:error", "serialport:read", "serialport:write", "feeder:status", "sender:status", "workflow:state", "gcode:load", "controller:state"];

async function main() {
  const answer = await fetch(`http://127.0.0.1:${port}/api/signin`, { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" });
  const { token } = await answer.json();
  const socket = io(`http://127.0.0.1:${port}`, { query: `token=${token}` });
  for (const event of EVENTS) socket.on(event, (...given) => console.log(JSON.stringify([event, ...given])));
  let rest = "";
  process.stdin.on("data", (data) => {
    const lines = (rest + data).split("\n");
    rest = lines.pop();
    for (const line of lines) socket.emit(...JSON.parse(line));
  });
  process.stdin.on("end", () => process.exit());
}

main();
