// A move while a button is held: a lease, renewed as long as the finger, the focus and the link are there. It names the newest report
// that the page has seen; a page that has few of them gets more while it moves the machine.

const KEEP_MS = 60;
const OFTEN_MS = 50;  // between reports

export class Jog {
  constructor(link, state, refused, refresh) {
    this.link = link;
    this.state = state;     // () => the newest report
    this.refused = refused; // (error)
    this.refresh = refresh; // () => milliseconds between reports as chosen; 0: only changes
    this.lease = 0;
    this.held = null;
    for (const event of ["blur", "pagehide"]) window.addEventListener(event, () => this.release());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); });
  }

  async press(way, speed, button) {
    if (this.held) return;
    const held = { button }, stops = this.link.stops;
    this.held = held;
    button.classList.add("held");
    if (this.seldom()) await this.link.look(OFTEN_MS).then(() => new Promise((seen) => { this.seen = seen; }));
    if (this.held !== held) return;
    if (this.link.stops !== stops) return this.drop();
    const report = this.state();
    this.lease = Math.max(this.lease, report.lease || 0) + 1;
    held.lease = this.lease;
    this.link.order({ do: "jog", lease: held.lease, beat: report.beat, way, speed }).then((answer) => {
      if (answer.error) {
        if (this.held === held) this.drop();
        this.refused(answer.error);
      }
    });
    held.timer = setInterval(() => this.renew(held), KEEP_MS);
  }

  renew(held) {
    if (this.held !== held) return;
    this.link.order({ do: "keep", lease: held.lease, beat: this.state().beat }).then((answer) => {
      if (answer.error && this.held === held) this.drop();
    });
  }

  // Let go; `button`: only if it is the one that is held, because another one takes the focus from it as it is pressed.
  release(button = null) {
    if (!this.held || (button && this.held.button !== button)) return;
    if (this.held.lease) this.link.order({ do: "release", lease: this.held.lease });
    this.drop();
  }

  seldom() { return !this.refresh() || this.refresh() > OFTEN_MS; }

  // A report has come.
  report() {
    if (this.seen) this.seen();
    this.seen = null;
  }

  drop() {
    clearInterval(this.held.timer);
    this.held.button.classList.remove("held");
    this.held = null;
    if (this.seldom()) this.link.look(this.refresh());
  }
}
