// A gamepad that moves the machine, and a camera with a cross: only where the browser trusts the page's address.

import { Fields, button, make, note, setText } from "./setup_parts.js";
import { words } from "./setup_lines.js";
import { _ } from "./words.js";

const DEAD = 0.3, SAME = 0.35;  // of a stick's way: at rest; another direction
const HOLD = 4, STOP = 1;  // buttons: left shoulder, the right one of the four
const sticks = (pad) => [pad.axes[0] || 0, -(pad.axes[1] || 0), -(pad.axes[3] || 0)].map((value) => (Math.abs(value) < DEAD ? 0 : value));

export class Pad {
  constructor(setup) {
    this.setup = setup;
    this.open = true;
    this.node = make("div");
    if (!window.isSecureContext) {
      this.node.append(make("p", { className: "reason", textContent: _("Browsers give a gamepad and a camera only to pages from 127.0.0.1 or by https. This one comes from {origin}. On the PC that runs passo panel, open its page at 127.0.0.1.", { origin: location.origin }) }));
      return;
    }
    this.way = [0, 0, 0];
    this.stopped = false;
    this.state = make("p", { className: "lamp", role: "status" });
    this.shown = make("b", { className: "note" });
    this.video = make("video", { muted: true, playsInline: true, autoplay: true });
    this.picture = make("div", { className: "camera", hidden: true }, this.video);
    this.eye = button(_("Camera on"), () => this.camera());
    this.cross = button(_("Zero of X and Y at the cross"), () => this.zero());
    this.fields = new Fields("camera", [{ name: "x", label: _("Camera from the tool, X, mm"), value: 0, min: -500, max: 500 }, { name: "y", label: _("Camera from the tool, Y, mm"), value: 0, min: -500, max: 500 }], () => {});
    this.node.append(make("h3", { textContent: _("Gamepad") }), this.state, note(_("Hold the left shoulder button: the left stick moves X and Y, the right one Z. Let go, and it stops. The right one of the four buttons is STOP.")),
      make("h3", { textContent: _("Camera") }), this.picture, make("p", { className: "row fill" }, this.eye, this.cross), this.fields.node);
    const look = () => { if (this.open) { this.look(); requestAnimationFrame(look); } };
    look();
  }

  look() {
    const pad = navigator.getGamepads && Array.from(navigator.getGamepads()).find(Boolean);
    this.state.dataset.lamp = pad ? "seen" : "";
    setText(this.state, pad ? pad.id : _("None is seen. Press one of its buttons."));
    if (!pad) return this.move([0, 0, 0]);
    const pressed = Boolean(pad.buttons[STOP] && pad.buttons[STOP].pressed);
    if (pressed && !this.stopped) this.setup.page.stop();
    this.stopped = pressed;
    return this.move(pad.buttons[HOLD] && pad.buttons[HOLD].pressed && !document.hidden ? sticks(pad) : [0, 0, 0]);
  }

  // A jog as by a button that is held: another one if the stick goes another way.
  move(way) {
    if (way.every((value, n) => Math.abs(value - this.way[n]) < SAME && (value === 0) === (this.way[n] === 0))) return;
    this.way = way;
    this.setup.page.letGo(this.state);
    const most = Math.max(...way.map(Math.abs)), axes = this.setup.page.axes(), by = {};
    if (!most || this.setup.locked()) return;
    way.forEach((value, n) => { if (value && axes[n]) by[axes[n]] = value / most; });
    if (Object.keys(by).length) this.setup.page.jog(by, most * most, this.state);
  }

  async camera() {
    if (this.stream) return this.dark();
    try {
      this.stream = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment" } });
    } catch (error) {
      return this.setup.page.say(_("There is no camera, or the browser was told not to give it."));
    }
    this.video.srcObject = this.stream;
    this.picture.hidden = false;
    this.eye.textContent = _("Camera off");
    return null;
  }

  dark() {
    if (!this.stream) return;
    for (const track of this.stream.getTracks()) track.stop();
    this.stream = this.video.srcObject = null;
    this.picture.hidden = true;
    this.eye.textContent = _("Camera on");
  }

  // The place under the cross is zero: the tool stands beside it.
  async zero() {
    const at = this.fields.values();
    if (at && (await this.setup.page.ask(_("Set the zero of X and Y under the camera's cross?")))) {
      this.setup.run([{ line: () => `G21G90G10L20P0${words({ x: -at.x, y: -at.y })}`, text: "" }]);
    }
  }

  show() { if (this.cross) this.cross.disabled = Boolean(this.setup.why(false)); }

  close() {
    this.open = false;
    if (!this.way) return;
    this.move([0, 0, 0]);
    this.dark();
  }
}
