// A job that was interrupted, and that the board's journal knows, or one that is to begin at a line: what will hold there is told, and it is
// asked before the tool goes down.

import { grey, isLaser } from "./controls.js";
import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);
const mm = (place, axes) => axes.map((axis) => `${"XYZ"[axis]} ${place[axis].toFixed(2)}`).join(" ");

export class Recover {
  // order(name, fields): a promise of the answer; job(): the name of the one that is chosen.
  constructor(order, job) {
    $("recover-begin").onclick = () => order("recover", { what: "begin", unverified: $("recover-sure").checked });
    $("recover-down").onclick = () => order("recover", { what: "down" });
    $("recover-drop").onclick = () => order("recover", { what: "drop" });
    $("recover-forget").onclick = () => order("recover", { what: "forget" });
    $("from-form").onsubmit = (event) => {
      event.preventDefault();
      $("recover-sure").checked = false;
      order("recover", { what: "from", name: job(), line: Number($("from-line").value) });
    };
  }

  // `offer`: of the state; `why`: of what is grey; `turns`: its spindle does.
  show(offer, why, turns) {
    $("recover-row").hidden = !offer;
    grey($("from-form").querySelector("button"), why.mine || why.idle || why.chosen);
    if (!offer) return;
    const text = offer.held ? this.told(offer) : this.stopped(offer, turns), head = offer.held ? _("Begin at a line") : _("A job was interrupted");
    if ($("recover-text").textContent !== text) $("recover-text").textContent = text;
    if ($("h-recover").textContent !== head) $("h-recover").textContent = head;
    $("recover-doubt").hidden = offer.known || offer.absent || Boolean(offer.next);
    $("recover-begin").hidden = offer.absent || Boolean(offer.next);
    $("recover-down").hidden = !offer.next;
    $("recover-drop").hidden = Boolean(offer.held) && !offer.next;
    $("recover-drop").textContent = isLaser() ? _("End it: laser off") : _("End it: tool up, spindle off");
    const sure = offer.known || $("recover-sure").checked ? "" : _("Look first whether zero is right.");
    grey($("recover-begin"), why.mine || why.idle || sure);
    grey($("recover-down"), why.mine || why.idle);
    for (const id of ["recover-drop", "recover-forget"]) grey($(id), why.mine || why.busy);
  }

  over(offer) {
    const [, depth, feed] = /G1Z([-\d.]+)F([\d.]+)$/.exec(offer.next) || [];
    const next = depth ? _("down to Z {depth} mm of the machine, at {feed} mm/min", { depth: Number(depth).toFixed(2), feed: Number(feed) }) : offer.next;
    return _("The tool is over the place. Next: {next}. Is the place right, and all clear?", { next });
  }

  stopped(offer, turns) {
    const laser = isLaser(), [on, off] = laser ? [_("{name} stopped in line {line}, the laser is on.", offer), _("{name} stopped in line {line}, laser off.", offer)]
      : [_("{name} stopped in line {line}, the spindle turns.", offer), _("{name} stopped in line {line}, spindle off.", offer)], text = turns ? on : off;
    if (offer.next) return `${text} ${this.over(offer)}`;
    if (offer.absent) return `${text} ${_("Its file is not among the jobs here: add it to go on.")}`;
    const way = laser ? _("It can go on there: over the place with the laser off, then you are asked.")
      : _("It can go on there: tool up, over the place, spindle and coolant on, then you are asked.");
    if (offer.known) return `${text} ${way}`;
    return `${text} ${_("Where the machine stands is not known since then: home it first.")}`;
  }

  // What is restored where a chosen line begins, in words.
  told(offer) {
    const { place, system, tool, spindle, rpm, coolant, feed, inches, absolute, laser } = offer.held;
    const on = [];
    if (tool) on.push(_("tool T{tool}", { tool }));
    if (spindle !== 5) on.push(laser ? _("laser power S{rpm}", { rpm }) : spindle === 3 ? _("spindle {rpm} rpm", { rpm }) : _("spindle {rpm} rpm, reversed", { rpm }));
    if (coolant & 1) on.push(_("flood coolant"));
    if (coolant & 2) on.push(_("mist coolant"));
    const words = { ...offer, system, over: mm(place, [0, 1].slice(0, place.length)), depth: place.length > 2 ? mm(place, [2]) : "", on: on.join(", ") || _("spindle and coolant off"),
      modes: [inches ? _("inches") : "mm", absolute ? _("absolute") : _("relative"), feed ? _("feed {feed} mm/min", { feed }) : ""].filter(Boolean).join(", ") };
    const text = _("{name}, from line {line}. Restored: {system}, {modes}.", words);
    if (offer.next) return `${text} ${this.over(offer)}`;
    const way = place.length > 2 ? _("Tool up, over {over} mm; {on}; then you are asked, and it goes down to {depth} mm.", words)
      : _("Over {over} mm; {on}; then you are asked, and it goes on.", words);
    return `${text} ${way}`;
  }
}
