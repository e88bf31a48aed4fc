// A drawing that is put elsewhere on the table, by a finger or by numbers; the PC makes its job anew.

const $ = (id) => document.getElementById(id);
const FIELDS = ["place-x", "place-y", "place-width"];

export class Place {
  // order(name, fields): a promise of the answer; picture; changed(): the job is another one now.
  constructor(order, picture, changed) {
    Object.assign(this, { order, picture, changed });
    for (const id of FIELDS) $(id).oninput = () => this.typed();
    $("place-finger").onclick = () => this.grasp($("place-finger").getAttribute("aria-pressed") !== "true");
    $("place-form").onsubmit = async (event) => {
      event.preventDefault();
      const [x, y, width] = this.box;
      if (!(await order("job_place", { name: this.name, x, y, width })).error) changed();
    };
  }

  // A job has been loaded; `about`: what is known of it.
  take(about) {
    const wanted = Boolean(about.placed);
    $("place-form").hidden = !wanted;
    if (!wanted || this.moves !== this.picture.moves) this.grasp(false);
    if (!wanted) return;
    this.name = about.name;
    if (this.shown === this.picture.moves) return;
    this.moves = this.shown = this.picture.moves;
    const box = [Infinity, Infinity, -Infinity];
    for (const move of this.moves) for (const [x, y] of move.rapid ? [] : move.points) {
      box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y); box[2] = Math.max(box[2], x);
    }
    if (box[2] < box[0]) return;
    this.from = [box[0], box[1], Math.max(0.001, box[2] - box[0])];
    this.set(this.from);
  }

  // A finger on the picture moves the drawing, two of them make it larger; or they move the view, as always.
  grasp(on) {
    $("place-finger").setAttribute("aria-pressed", on);
    this.picture.view.hand = on ? {
      move: (x, y) => this.set([this.box[0] + x, this.box[1] + y, this.box[2]]),
      size: (by) => this.set([this.box[0], this.box[1], this.box[2] * by]),
    } : null;
    if (on && this.picture.table) this.picture.view.fit(this.picture.table.box);
  }

  typed() {
    const box = FIELDS.map((id) => Number($(id).value));
    if (box[2] > 0) this.set(box, false);
  }

  // [left, lowest, width] in mm: the picture shows it at once.
  set(box, fill = true) {
    this.box = box;
    if (fill) FIELDS.forEach((id, n) => { $(id).value = box[n].toFixed(1); });
    const by = box[2] / this.from[2], at = ([x, y]) => [box[0] + (x - this.from[0]) * by, box[1] + (y - this.from[1]) * by];
    this.picture.moves = this.shown = this.moves.map((move) => ({ ...move, points: move.points.map(at) }));
    this.picture.draw();
  }
}
