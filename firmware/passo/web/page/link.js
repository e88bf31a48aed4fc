// The link to the server: a WebSocket, a session, answers by number.

import { hex, hmac } from "./sha256.js";

const MOST = 90;  // orders under way; the server takes a STOP that names more than 100 for another's (passo/web/pages.py)
const bytes = (text) => new TextEncoder().encode(text);

export class Link {
  // told(message): everything that is no answer; up(open): the link is there, or is not.
  constructor(told, up) {
    this.told = told;
    this.up = up;
    this.key = "";
    this.sent = "";  // nonce and count of the newest order
    this.stops = 0;  // how often STOP was pressed
    this.waiting = new Map();
    this.id = 0;
    this.open();
  }

  open() {
    this.nonce = "";
    this.count = 0;
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.onmessage = (event) => this.hear(JSON.parse(event.data));
    this.socket.onclose = () => this.lost();
  }

  hear(message) {
    if (message.t === "hello") {
      this.nonce = message.nonce;
      this.up(true);
    }
    if (message.t === "answer" && !message.do && !("id" in message) && this.waiting.size) message.id = this.waiting.keys().next().value;  // in order
    if (this.waiting.has(message.id)) {
      this.waiting.get(message.id)(message);
      this.waiting.delete(message.id);
    }
    if (message.t !== "answer") this.told(message);
  }

  lost() {
    this.nonce = "";
    for (const answer of this.waiting.values()) answer({ error: 170 });
    this.waiting.clear();
    this.up(false);
    setTimeout(() => this.open(), 1000);
  }

  ready() { return this.nonce !== "" && this.socket.readyState === WebSocket.OPEN; }

  // Send an order with its proof; a promise of the answer.
  order(order) {
    if (!this.ready()) return Promise.resolve({ error: 170 });
    if (!this.key) return Promise.resolve({ error: 172 });
    if (this.waiting.size >= MOST) return Promise.resolve({ error: 108 });
    const id = ++this.id;
    const body = JSON.stringify({ ...order, id });
    const count = String(++this.count);
    this.sent = `${this.nonce}.${count}`;
    const proof = hex(hmac(bytes(this.key), bytes(`${this.nonce}.${count}.${body}`)));
    this.socket.send(`${count}.${proof}.${body}`);
    return new Promise((answer) => this.waiting.set(id, answer));
  }

  // How often the state comes, in milliseconds; 0: only changes. Needs no key.
  look(every) {
    if (!this.ready()) return Promise.resolve({ error: 170 });
    const id = ++this.id;
    this.socket.send(JSON.stringify({ do: "look", every, id }));
    return new Promise((answer) => this.waiting.set(id, answer));
  }

  // STOP goes both ways at once, and needs no key. It may overtake orders that are under way: by the last one's count the server knows them.
  // A promise of 0, or of the error that says why it may not have arrived.
  stop() {
    this.stops++;
    if (this.ready()) this.socket.send('{"do":"stop"}');
    return fetch("stop", { method: "POST", body: this.sent }).then((answer) => answer.json()).then(({ error }) => error).catch(() => 183);
  }
}
