// A job that was interrupted, and that the board's journal knows: it is offered to go on with it, and asked before the tool goes down.

import { _ } from "./words.js";

const $ = (id) => document.getElementById(id);

export class Recover {
  // order(name, fields): a promise of the answer.
  constructor(order) {
    $("recover-begin").onclick = () => order("recover", { what: "begin", unverified: $("recover-sure").checked });
    $("recover-down").onclick = () => order("recover", { what: "down" });
    $("recover-drop").onclick = () => order("recover", { what: "drop" });
    $("recover-forget").onclick = () => order("recover", { what: "forget" });
  }

  // `offer`: of the state; `free`: nothing runs, and this page commands; `idle`: the machine is; `turns`: its spindle does.
  show(offer, free, idle, turns) {
    $("recover-row").hidden = !offer;
    if (!offer) return;
    let text = (turns ? _("{name} stopped in line {line}, the spindle turns.", offer) : _("{name} stopped in line {line}, spindle off.", offer)) + " ";
    if (offer.next) text += _("The tool is over the place. Next: {next}. Is the place right, and all clear?", offer);
    else if (offer.known) text += _("It can go on there: tool up, over the place, spindle and coolant on, then you are asked.");
    else text += _("Where the machine stands is not known since then: home it first.");
    if ($("recover-text").textContent !== text) $("recover-text").textContent = text;
    $("recover-doubt").hidden = offer.known || Boolean(offer.next);
    $("recover-begin").hidden = Boolean(offer.next);
    $("recover-down").hidden = !offer.next;
    $("recover-begin").disabled = !free || !idle || !(offer.known || $("recover-sure").checked);
    $("recover-down").disabled = !free || !idle;
    $("recover-drop").disabled = $("recover-forget").disabled = !free;
  }
}
