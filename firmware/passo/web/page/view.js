// How a picture looks at the machine: from above, or turned; moved and zoomed by fingers, mouse and wheel.

const LEAST = 0.05, MOST = 400;  // pixels a millimetre
const NEAR = 6;                  // pixels: a touch that moves less is a tap

const spread = (one, other) => Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;

export class View {
  // canvas; changed(): draw anew; tapped(x, y): pixels of the canvas.
  constructor(canvas, changed, tapped) {
    Object.assign(this, { canvas, changed, tapped });
    this.middle = [0, 0, 0];
    this.scale = 2;
    this.solid = false;
    this.hand = null;  // { move(x, y) in mm, size(by) }: fingers carry what is shown, not the view
    this.turn(0, 0);
    this.fingers = new Map();
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, ...this.inside(event)); }, { passive: false });
    if (!window.PointerEvent) { canvas.onclick = (event) => tapped(...this.inside(event)); return; }
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.up(event));
  }

  // Around the vertical, and down from above, in radians.
  turn(around, down) {
    this.around = around;
    this.down_ = Math.max(0, Math.min(Math.PI / 2, down));
    [this.cos, this.sin, this.flat, this.high] = [Math.cos(around), Math.sin(around), Math.cos(this.down_), Math.sin(this.down_)];
  }

  stand(solid) {
    this.solid = solid;
    this.turn(solid ? -0.5 : 0, solid ? 0.95 : 0);
  }

  // Pixels of a point in mm.
  at(point) {
    const x = point[0] - this.middle[0], y = point[1] - this.middle[1], z = (point[2] || 0) - this.middle[2];
    const along = x * this.cos - y * this.sin, away = x * this.sin + y * this.cos;
    return [this.canvas.width / 2 + along * this.scale, this.canvas.height / 2 - (away * this.flat + z * this.high) * this.scale];
  }

  // The point on the plane of the middle that is seen at these pixels.
  place(px, py) {
    const along = (px - this.canvas.width / 2) / this.scale, away = (this.canvas.height / 2 - py) / this.scale / Math.max(0.05, this.flat);
    return [this.middle[0] + along * this.cos + away * this.sin, this.middle[1] - along * this.sin + away * this.cos];
  }

  // All of a box [[low, high] of x, y, z] is seen.
  fit(box) {
    this.middle = box.map(([low, high]) => (low + high) / 2);
    this.scale = 1;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => this.at(box.map((ends, axis) => ends[n >> axis & 1])));
    const size = (axis) => Math.max(...corners.map((each) => each[axis])) - Math.min(...corners.map((each) => each[axis]));
    this.scale = Math.min(MOST, 0.9 * Math.min(this.canvas.width / Math.max(10, size(0)), this.canvas.height / Math.max(10, size(1))));
    this.changed();
  }

  zoom(by, px = this.canvas.width / 2, py = this.canvas.height / 2) {
    const before = this.place(px, py);
    this.scale = Math.max(LEAST, Math.min(MOST, this.scale * by));
    const after = this.place(px, py);
    this.move(before[0] - after[0], before[1] - after[1]);
  }

  move(x, y) {
    this.middle = [this.middle[0] + x, this.middle[1] + y, this.middle[2]];
    this.changed();
  }

  inside(event) {
    const box = this.canvas.getBoundingClientRect(), dense = this.canvas.width / box.width;
    return [(event.clientX - box.left) * dense, (event.clientY - box.top) * dense];
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.inside(event));
    this.far = this.fingers.size > 1 ? Infinity : 0;
  }

  drag(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const now = this.inside(event);
    this.far += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (this.far < NEAR) return;
    this.fingers.set(event.pointerId, now);
    const other = Array.from(this.fingers).filter(([id]) => id !== event.pointerId).map(([, place]) => place)[0];
    if (this.hand && other) this.hand.size(spread(now, other) / spread(before, other));
    else if (this.hand) this.carry(before, now);
    else if (other) this.pinch(before, now, other);
    else if (this.solid) this.orbit(now[0] - before[0], now[1] - before[1]);
    else this.pan(before, now);
  }

  pan(before, now) {
    const from = this.place(...before), to = this.place(...now);
    this.move(from[0] - to[0], from[1] - to[1]);
  }

  // What is under the finger goes with it.
  carry(before, now) {
    const from = this.place(...before), to = this.place(...now);
    this.hand.move(to[0] - from[0], to[1] - from[1]);
  }

  orbit(across, up) {
    this.turn(this.around + across / 200, this.down_ - up / 200);
    this.changed();
  }

  pinch(before, now, other) {
    const middle = (place) => [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
    this.pan(middle(before), middle(now));
    this.zoom(spread(now, other) / spread(before, other), ...middle(now));
  }

  up(event) {
    const there = this.fingers.delete(event.pointerId);
    if (there && event.type === "pointerup" && this.far < NEAR) this.tapped(...this.inside(event));
  }
}
