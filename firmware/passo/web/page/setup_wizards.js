// Wizards that find the work with a probe: what is asked, where the tool is to stand, the steps, and what they are drawn over.
// Each step is a line of G-code that the firmware has already (G38.2, G38.3, G10); no rule of the machine is here.

import { _ } from "./words.js";

const mm = (name, label, value, min, max) => ({ name, label, value, min, max });
const more = (...fields) => ({ ...mm(...fields), more: true });
const speeds = () => [more("fast", _("First touch, mm/min"), 120, 1, 2000), more("slow", _("Second touch, mm/min"), 30, 1, 500), more("back", _("Back between them, mm"), 2, 0.2, 20)];
const travelling = () => more("travel", _("Between touches, mm/min"), 800, 10, 10000);
const diameter = () => mm("tool", _("Diameter of the tool or probe, mm"), 6, 0.01, 100);

// Two touches along an axis, the second one slow; `near`: where the picture has the work.
function touch(p, axis, sign, far, near, keep, what) {
  const back = { [axis]: -sign * p.back };
  return [
    { by: { [axis]: sign * far }, near, probe: true, feed: p.fast, text: _("Seek: {what}", { what }) },
    { by: back, text: _("Back") },
    { by: { [axis]: sign * 2 * p.back }, near: p.back, probe: true, feed: p.slow, keep, text: _("Touch slowly: {what}", { what }) },
    { by: back, text: _("Back") },
  ];
}

// A way on which nothing may be touched.
const free = (p, by, text) => ({ by, free: true, feed: p.travel, text });
const rapid = (by, text) => ({ by, text });
const zero = (text, set, of) => ({ text, set, of });
const mean = (one, other, n) => (one[n] + other[n]) / 2;

function plateSteps(p) {
  return [...touch(p, "z", -1, p.far, p.far / 2, "z", _("plate")),
    zero(_("Set Z"), () => ({ z: p.plate }), (touched) => ({ z: touched.z[2] })),
    rapid({ z: p.back }, _("Up"))];
}

const CORNERS = { fl: [1, 1], fr: [-1, 1], bl: [1, -1], br: [-1, -1] };

function cornerSteps(p) {
  const [sx, sy] = CORNERS[p.corner], r = p.tool / 2, down = p.back + p.depth, side = p.inset + p.over;
  const faces = [["x", sx, _("side of X")], ["y", sy, _("side of Y")]];
  const steps = [...touch(p, "z", -1, p.far, p.far / 2, "z", _("top")), zero(_("Set Z"), () => ({ z: p.plate }), (touched) => ({ z: touched.z[2] }))];
  faces.forEach(([axis, sign, what], n) => {
    const last = n === faces.length - 1, value = -sign * (r + p.wall);
    steps.push(free(p, { [axis]: -sign * side }, _("Out over the edge")), free(p, { z: -down }, _("Down beside it")),
      ...touch(p, axis, sign, p.over + p.inset, p.over - r - p.wall, axis, what),
      zero(axis === "x" ? _("Set X") : _("Set Y"), () => ({ [axis]: value }), (touched) => ({ [axis]: touched[axis][n] })),
      rapid({ z: down }, _("Up")));
    if (!last) steps.push(rapid({ [axis]: sign * (p.inset + r + p.wall + p.back) }, _("Back over the work")));
  });
  steps.push({ by: { x: -sx * p.inset, y: sy * (r + p.wall + p.back) }, line: () => "G21G90G0X0Y0", text: _("Over the corner") });
  return steps;
}

function cornerShapes(p) {
  const [sx, sy] = CORNERS[p.corner], l = p.inset + 30, x = [0, sx * l].sort((a, b) => a - b), y = [0, sy * l].sort((a, b) => a - b);
  return [["box", [x[0], y[0], -p.depth - 8, x[1], y[1], 0]]];
}

const AXES = ["x", "y"];

function holeSteps(p) {
  const r = p.tool / 2, half = p.size / 2 - r, steps = [];
  AXES.forEach((axis, n) => {
    steps.push(...touch(p, axis, -1, p.size, half, `${axis}0`, _("wall")),
      ...touch(p, axis, 1, 2 * p.size, 2 * half - p.back, `${axis}1`, _("opposite wall")),
      { by: { [axis]: -half + p.back }, line: (touched) => `G21G90G53G0${axis.toUpperCase()}${mean(touched[`${axis}0`], touched[`${axis}1`], n).toFixed(3)}`, text: _("To the middle") });
  });
  return steps.concat(centred());
}

function bossSteps(p) {
  const r = p.tool / 2, side = p.size / 2 + p.over + r, down = p.above + p.depth, steps = [];
  AXES.forEach((axis, n) => {
    for (const sign of [-1, 1]) {
      const key = `${axis}${sign < 0 ? 0 : 1}`;
      steps.push(free(p, { [axis]: sign * side }, _("Out over the edge")), free(p, { z: -down }, _("Down beside it")),
        ...touch(p, axis, -sign, 2 * p.over, p.over, key, _("side")), rapid({ z: down }, _("Up")));
      steps.push(sign < 0 ? rapid({ [axis]: p.size / 2 + r + p.back }, _("Back over the work"))
        : { by: { [axis]: -(p.size / 2 + r + p.back) }, line: (touched) => `G21G90G53G0${axis.toUpperCase()}${mean(touched[`${axis}0`], touched[`${axis}1`], n).toFixed(3)}`, text: _("To the middle") });
    }
  });
  return steps.concat(centred());
}

const centred = () => [zero(_("Set X and Y"), () => ({ x: 0, y: 0 }), (touched) => ({ x: mean(touched.x0, touched.x1, 0), y: mean(touched.y0, touched.y1, 1) }))];

function toolSteps(p, low) {
  return [...touch(p, "z", -1, p.far, p.far / 2, "z", _("sensor")),
    { line: (touched) => `G21G90G10L1P${p.number}Z${(touched.z[2] - low).toFixed(3)}`, text: _("Store the length") },
    { line: () => `G43H${p.number}`, text: _("Use the length") },
    rapid({ z: p.back }, _("Up"))];
}

const far = () => more("far", _("Farthest way down, mm"), 20, 1, 200);
const plate = (value) => mm("plate", _("Thickness of the plate, mm"), value, 0, 100);

// key: { title, stand, fields, steps(values, low end of Z), shapes(values), start(values), rise(values): mm that a dry run goes up first }
export const wizards = () => ({
  plate: {
    title: _("Z with a touch plate"),
    stand: _("Put the plate on the work, its clip on the tool. Stand over the plate."),
    fields: [plate(12), far(), ...speeds()],
    steps: plateSteps,
    shapes: (p) => [["box", [-40, -26, -p.plate - 20, 40, 26, -p.plate]], ["plate", [-12, -9, -p.plate, 12, 9, 0]]],
    start: (p) => [0, 0, p.far / 2],
    tool: () => 3,
  },
  corner: {
    title: _("Corner of the work"),
    stand: _("Stand over the work near the corner, as far in from both sides as is said below. X, Y and Z are set: zero is the corner of the top."),
    fields: [{ name: "corner", label: _("Corner"), value: "fl", options: [["fl", _("front left")], ["fr", _("front right")], ["bl", _("back left")], ["br", _("back right")]] },
      diameter(), mm("inset", _("In from both sides, mm"), 15, 1, 200), mm("over", _("Out beyond the side, mm"), 12, 1, 200), mm("depth", _("Down below the top, mm"), 6, 0.5, 100),
      plate(0), mm("wall", _("Wall of the plate, mm"), 0, 0, 100), far(), travelling(), ...speeds()],
    steps: cornerSteps,
    shapes: cornerShapes,
    start: (p) => [CORNERS[p.corner][0] * p.inset, CORNERS[p.corner][1] * p.inset, p.far / 2],
    tool: (p) => p.tool / 2,
  },
  hole: {
    title: _("Centre of a hole"),
    stand: _("Stand in the hole, near its middle, the tip below the edge. X and Y are set: zero is the centre."),
    fields: [mm("size", _("About how wide, mm"), 30, 1, 500), diameter(), ...speeds()],
    steps: holeSteps,
    shapes: (p) => [["box", [-p.size, -p.size * 0.8, -14, p.size, p.size * 0.8, 0]], ["hole", [0, 0, p.size / 2, 0]]],
    start: () => [0, 0, -4],
    tool: (p) => p.tool / 2,
    flat: true,
  },
  boss: {
    title: _("Centre of a boss"),
    stand: _("Stand over the middle of the boss, as high above its top as is said below. X and Y are set: zero is the centre."),
    fields: [mm("size", _("About how wide, mm"), 24, 1, 500), diameter(), mm("above", _("Above the top, mm"), 4, 0.5, 100), mm("over", _("Out beyond the side, mm"), 12, 1, 200), mm("depth", _("Down below the top, mm"), 6, 0.5, 100),
      travelling(), ...speeds()],
    steps: bossSteps,
    shapes: (p) => [["boss", [0, 0, p.size / 2, -p.depth - 8, 0]]],
    start: (p) => [0, 0, p.above],
    tool: (p) => p.tool / 2,
  },
  tool: {
    title: _("Tool length"),
    stand: _("Stand over the length sensor or a fixed plate: the same place for each tool. The length is stored as that of this tool, and used from now on."),
    fields: [mm("number", _("Number of the tool"), 1, 1, 16), far(), ...speeds()],
    steps: toolSteps,
    shapes: () => [["plate", [-12, -9, -12, 12, 9, 0]], ["box", [-30, -20, -22, 30, 20, -12]]],
    start: (p) => [0, 0, p.far / 2],
    tool: () => 3,
  },
});

// The way of a dry run: up, then the same without going down and without touching. `lift`: mm.
export function dry(steps, lift, travel) {
  const made = [{ by: { z: lift }, feed: travel, text: _("Up") }];
  for (const step of steps) {
    if (!step.by) continue;
    const by = {};
    for (const axis of Object.keys(step.by)) if (axis !== "z") by[axis] = step.probe ? Math.sign(step.by[axis]) * step.near : step.by[axis];
    if (Object.keys(by).length) made.push({ by, feed: travel, text: step.text });
  }
  return made.concat({ by: { z: -lift }, feed: travel, text: _("Down") });
}
