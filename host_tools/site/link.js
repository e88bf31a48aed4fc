// The link to the machine of this tab: a worker in place of a server. The page's own link.js has the same class.

const AGAIN_MS = 1000;

export class Link {
  // told(message): everything that is no answer; up(open): the link is there, or is not.
  constructor(told, up) {
    this.told = told;
    this.up = up;
    this.waiting = new Map();
    this.id = 0;
    this.stops = 0;  // how often STOP was pressed
    this.open = false;
    this.board = new URLSearchParams(location.search).get("board");
    this.start();
  }

  // Whoever has the tab has the key.
  get key() { return "tab"; }
  set key(text) {}

  async start() {
    this.site = this.site || await (await fetch("site.json")).json();
    if (!(this.board in this.site.boards)) this.board = Object.keys(this.site.boards)[0];
    const worker = new Worker("worker.js", { type: "module" });
    this.worker = worker;
    worker.onmessage = (event) => { if (worker === this.worker) this.hear(event.data); };
    worker.onerror = (event) => { if (worker === this.worker) this.lost(event.message); };
    worker.postMessage({ start: this.board });
  }

  hear(data) {
    if (typeof data !== "string") return this.lost(data.fault);
    const message = JSON.parse(data);
    if (message.t === "hello") {
      const others = message.machines.filter((name) => name !== this.board);
      message.machines = [this.board, ...others];
      message.rules = this.site.rules;
      this.open = true;
      this.told(message);
      this.up(true);
      return;
    }
    if (this.waiting.has(message.id)) {
      this.waiting.get(message.id)(message);
      this.waiting.delete(message.id);
    }
    if (message.t === "machine" || message.t === "table") dispatchEvent(new CustomEvent("machine", { detail: message }));
    else if (message.t !== "answer") this.told(message);
  }

  lost(fault) {
    console.error(fault);
    this.stopped();
    setTimeout(() => this.start(), AGAIN_MS);
  }

  stopped() {
    this.worker.terminate();
    this.worker = null;
    this.open = false;
    for (const answer of this.waiting.values()) answer({ error: 170 });
    this.waiting.clear();
    this.up(false);
  }

  ready() { return this.open; }

  // Send an order; a promise of the answer. Another machine is another worker.
  order(order) {
    if (!this.open) return Promise.resolve({ error: 170 });
    if (order.do === "machine") {
      this.board = order.name;
      this.stopped();
      this.start();
      return Promise.resolve({ error: 0 });
    }
    const id = ++this.id;
    this.worker.postMessage(JSON.stringify({ ...order, id }));
    return new Promise((answer) => this.waiting.set(id, answer));
  }

  look(every) { return this.order({ do: "look", every }); }

  stop() {
    this.stops++;
    if (this.open) this.worker.postMessage('{"do":"stop"}');
    return Promise.resolve(this.open ? 0 : 183);
  }
}
