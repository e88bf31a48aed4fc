// The machine, drawn from where its carriages are: seen from above at a slant. The trail is where the tool has been.

const TURN = 0.42, TILT = 0.62;      // of the view, in radians, and how much height is seen
const HEAD = 20, ASIDE = 15;         // mm: a pen's head above the paper; the bridge's sides outside of the travel
const MOST_PLACES = 60000;

const $ = (id) => document.getElementById(id);
const canvas = $("machine-view");
const ink = canvas.getContext("2d");
let table = null;                    // what the worker says of the machine once
let now = null;                      // its newest report
let trail = [];                      // [x, y, z, tool] in mm
let pace = null;                     // {ms, at} of a time in which it moved
let shown = 100;
let asked = false;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

addEventListener("machine", ({ detail }) => {
  if (detail.t === "table") {
    table = detail;
    trail = [];
    now = pace = null;
    canvas.dataset.board = detail.board;
    fit();
  } else if (table) {
    now = detail;
    const axes = table.axes.length;
    for (let at = 0; at < detail.trail.length; at += axes + 1) {
      trail.push([...place(detail.trail.slice(at, at + axes)), detail.trail[at + axes]]);
    }
    if (trail.length > MOST_PLACES) trail = trail.filter((_, n) => n % 2);
    measure(detail);
  }
  if (!asked) { asked = true; requestAnimationFrame(draw); }
});

// [x, y, z] in mm of steps; a plotter's z is its pen.
function place(steps) {
  const mm = steps.map((step, axis) => step / table.scale[axis]);
  return [mm[0], mm[1], mm.length > 2 ? mm[2] : 0];
}

// How much machine time passes in a second of the wall clock while something moves.
function measure(report) {
  const at = performance.now();
  if (!report.moving) pace = null;
  else if (!pace) pace = { ms: report.ms, at };
  else if (at - pace.at > 1000) {
    shown = Math.round(((report.ms - pace.ms) / (at - pace.at)) * 100);
    pace = { ms: report.ms, at };
  }
  $("machine-pace").textContent = `${shown} %`;
  $("machine-faults").textContent = report.faults;
  canvas.dataset.at = report.at.join(" ");
  canvas.dataset.trail = trail.length;
}

let scale = 1, left = 0, top_ = 0;

// x to the right and down a little, y to the right and up, z up.
function flat([x, y, z]) {
  const along = x * Math.cos(TURN) + y * Math.sin(TURN) * 0.8;
  const away = -x * Math.sin(TURN) * 0.5 + y * Math.cos(TURN);
  return [along, -away * TILT - z];
}

const at = (point) => { const [x, y] = flat(point); return [left + x * scale, top_ + y * scale]; };

function corners() {
  const [low, high] = [place(table.low), place(table.high)];
  return { low, high: [high[0], high[1], table.axes.length > 2 ? high[2] : HEAD] };
}

function fit() {
  const { low, high } = corners();
  const all = [];
  for (const x of [low[0], high[0]]) for (const y of [low[1], high[1]]) for (const z of [low[2], high[2]]) all.push(flat([x, y, z]));
  const xs = all.map((point) => point[0]), ys = all.map((point) => point[1]);
  const width = Math.max(...xs) - Math.min(...xs), height = Math.max(...ys) - Math.min(...ys);
  scale = Math.min(canvas.width / (width * 1.12), canvas.height / (height * 1.2));
  left = (canvas.width - (Math.min(...xs) + Math.max(...xs)) * scale) / 2;
  top_ = (canvas.height - (Math.min(...ys) + Math.max(...ys)) * scale) / 2;
}

function line(points, stroke, width = 1) {
  ink.beginPath();
  points.forEach((point, n) => ink[n ? "lineTo" : "moveTo"](...at(point)));
  ink.strokeStyle = stroke;
  ink.lineWidth = width;
  ink.stroke();
}

function draw() {
  asked = false;
  if (!table) return;
  const { low, high } = corners();
  const floor = table.axes.length > 2 ? low[2] : 0;
  const soft = colour("--line"), text = colour("--soft"), key = colour("--key");
  ink.clearRect(0, 0, canvas.width, canvas.height);
  const [x0, y0, x1, y1] = [low[0], low[1], high[0], high[1]];
  for (let x = Math.ceil(x0 / 50) * 50; x <= x1; x += 50) line([[x, y0, floor], [x, y1, floor]], soft);
  for (let y = Math.ceil(y0 / 50) * 50; y <= y1; y += 50) line([[x0, y, floor], [x1, y, floor]], soft);
  line([[x0, y0, floor], [x1, y0, floor], [x1, y1, floor], [x0, y1, floor], [x0, y0, floor]], text, 2);
  drawTrail();
  if (!now) return;
  const [x, y, z] = place(now.at);
  const head = table.axes.length > 2 ? high[2] + ASIDE : HEAD;
  for (const side of [x0 - ASIDE, x1 + ASIDE]) line([[side, y, floor], [side, y, head]], text, 5);
  line([[x0 - ASIDE, y, head], [x1 + ASIDE, y, head]], text, 7);
  const tip = table.axes.length > 2 ? z : now.tool ? 0 : 4;
  line([[x, y, head], [x, y, tip + 8]], key, 9);
  line([[x, y, tip + 8], [x, y, tip]], now.tool ? colour("--tool") : key, 3);
  ink.fillStyle = now.tool ? colour("--tool") : key;
  ink.beginPath();
  ink.arc(...at([x, y, tip]), 4, 0, 7);
  ink.fill();
}

function drawTrail() {
  const cut = colour("--done"), way = colour("--path");
  for (let n = 1; n < trail.length;) {
    const on = trail[n][3] > 0;
    ink.beginPath();
    ink.moveTo(...at(trail[n - 1]));
    while (n < trail.length && trail[n][3] > 0 === on) ink.lineTo(...at(trail[n++]));
    ink.strokeStyle = on ? cut : way;
    ink.lineWidth = on ? 1.6 : 0.5;
    ink.stroke();
  }
}

$("machine-wipe").onclick = () => { trail = trail.slice(-1); draw(); };
