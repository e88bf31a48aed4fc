// The small picture of a job in its machine's tile.

export const WIDTH = 320, HEIGHT = 180;
const EDGE = 8, NEAR = 0.3;  // pixels

// {strokes: [{line, points: [x, y, x, y, …]}], last} of moves as gcode_path.js reads them, in pixels; null: nothing is drawn. A point nearer than
// NEAR to the one before it is left out, so the strokes of 150 000 points cost no more than their pixels.
export function thumbnail(moves) {
  let left = Infinity, right = -Infinity, low = Infinity, high = -Infinity;
  for (const move of moves) {
    if (move.rapid) continue;
    for (const [x, y] of move.points) {
      left = Math.min(left, x);
      right = Math.max(right, x);
      low = Math.min(low, y);
      high = Math.max(high, y);
    }
  }
  if (left > right) return null;
  const scale = Math.min((WIDTH - 2 * EDGE) / (right - left || 1), (HEIGHT - 2 * EDGE) / (high - low || 1));
  const pixels = ([x, y]) => [WIDTH / 2 + (x - (left + right) / 2) * scale, HEIGHT / 2 - (y - (low + high) / 2) * scale];
  const strokes = [];
  let at = null;
  for (const move of moves) {
    if (move.rapid) {
      at = null;
      continue;
    }
    let points = [];
    for (const point of move.points) {
      const to = pixels(point);
      if (at && Math.hypot(to[0] - at[0], to[1] - at[1]) < NEAR) continue;
      if (at && !points.length) points.push(...at);
      points.push(...to);
      at = to;
    }
    if (points.length) strokes.push({ line: move.line, points });
  }
  return { strokes, last: moves[moves.length - 1].line };
}

// Draw it: what is done up to `progress` per cent in the colour `done`, the rest in `path`.
export function paint(canvas, picture, progress, { path, done }) {
  canvas.width = WIDTH;
  canvas.height = HEIGHT;
  const context = canvas.getContext("2d"), last = picture.last * progress / 100;
  for (const part of [false, true]) {
    context.beginPath();
    for (const { line, points } of picture.strokes) {
      if ((line <= last) !== part) continue;
      for (let n = 0; n < points.length; n += 2) context[n ? "lineTo" : "moveTo"](points[n], points[n + 1]);
    }
    context.strokeStyle = part ? done : path;
    context.lineWidth = part ? 2.5 : 1.5;
    context.stroke();
  }
}
