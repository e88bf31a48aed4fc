// The picture of a wizard: the work and the way of the tool, seen from the front, a little from above.

const SLANT = 0.42;  // of a depth, to the right and up
const NS = "http://www.w3.org/2000/svg";
const at = ([x, y, z]) => [x + SLANT * y, -z - SLANT * y];
const joined = (points) => points.map((point) => at(point).map((value) => value.toFixed(2)).join(",")).join(" ");
const TURNS = Array.from({ length: 37 }, (_, n) => n * Math.PI / 18);
const ring = (x, y, r, z) => TURNS.map((angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle), z]);

function svg(tag, about) {
  const made = document.createElementNS(NS, tag);
  for (const name of Object.keys(about)) made.setAttribute(name, about[name]);
  return made;
}

// Faces that are seen of a box [x0, y0, z0, x1, y1, z1].
function box([x0, y0, z0, x1, y1, z1], kind) {
  return [["front", [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]]], ["side", [[x1, y0, z0], [x1, y1, z0], [x1, y1, z1], [x1, y0, z1]]],
    ["top", [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]]]].map(([face, points]) => [`${kind} ${face}`, points]);
}

function boss([x, y, r, z0, z1]) {
  return [["work front", [...ring(x, y, r, z0).slice(18), ...ring(x, y, r, z1).slice(18).reverse()]], ["work top", ring(x, y, r, z1)]];
}

const SHAPES = { box: (each) => box(each, "work"), plate: (each) => box(each, "plate"), boss, hole: ([x, y, r, z]) => [["hole", ring(x, y, r, z)]] };

// Where the tool is at the end of each step, from [x, y, z] on.
export function places(start, steps) {
  const found = [start];
  for (const { by, near, probe } of steps) {
    const last = found[found.length - 1];
    found.push(by ? last.map((value, n) => value + (probe ? Math.sign(by["xyz"[n]] || 0) * near : by["xyz"[n]] || 0)) : last);
  }
  return found;
}

export class Scene {
  constructor(label) {
    this.node = svg("svg", { class: "scene", role: "img", "aria-label": label });
    this.timer = 0;
  }

  // shapes: [[kind, numbers]]; steps from start; the tool's radius.
  draw(shapes, start, steps, radius) {
    this.way = places(start, steps);
    this.radius = radius;
    const drawn = [];
    const points = [];
    for (const [kind, each] of shapes) {
      for (const [name, corners] of SHAPES[kind](each)) {
        points.push(...corners);
        drawn.push(svg("polygon", { class: name, points: joined(corners) }));
      }
    }
    steps.forEach((step, n) => {
      if (step.by) drawn.push(svg("polyline", { class: step.probe ? "way probing" : step.free ? "way free" : "way", points: joined([this.way[n], this.way[n + 1]]) }));
      if (step.probe && step.keep) drawn.push(svg("circle", { class: "touched", r: 1, cx: at(this.way[n + 1])[0], cy: at(this.way[n + 1])[1] }));
    });
    points.push(...this.way);
    const flat = points.map(at), xs = flat.map(([x]) => x), ys = flat.map(([, y]) => y), edge = radius + 3;
    const low = [Math.min(...xs) - edge, Math.min(...ys) - edge - 14], size = [Math.max(...xs) + edge - low[0], Math.max(...ys) + edge - low[1]];
    this.node.setAttribute("viewBox", [...low, ...size].map((value) => value.toFixed(1)).join(" "));
    const scale = Math.max(size[0] / 320, size[1] / 170);
    for (const circle of drawn) if (circle.tagName === "circle") circle.setAttribute("r", 4 * scale);
    this.tool = svg("polygon", { class: "tool" });
    this.node.replaceChildren(...drawn, this.tool);
    this.mark(0);
  }

  // The tool at the end of `n` steps, or between.
  mark(n) {
    if (!this.way) return;
    const first = Math.min(Math.floor(n), this.way.length - 1), next = Math.min(first + 1, this.way.length - 1), part = n - Math.floor(n);
    const [x, y, z] = this.way[first].map((value, axis) => value + (this.way[next][axis] - value) * part), r = this.radius;
    this.tool.setAttribute("points", joined([...ring(x, y, r, z).slice(18), ...ring(x, y, r, z + 14).slice(0, 19)]));
  }

  // Go the way once.
  play() {
    clearInterval(this.timer);
    const slow = matchMedia("(prefers-reduced-motion: reduce)").matches, by = slow ? 1 : 0.05;
    let n = 0;
    this.timer = setInterval(() => {
      n += by;
      this.mark(Math.min(n, this.way.length - 1));
      if (n >= this.way.length - 1) clearInterval(this.timer);
    }, slow ? 700 : 35);
  }

  end() { clearInterval(this.timer); }
}
