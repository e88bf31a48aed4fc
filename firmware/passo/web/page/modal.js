// A dialog that leaves STOP in reach: while it is open the button is a part of it, at the same spot of the screen, for nothing outside a dialog can be pressed.

const stop = document.getElementById("stop");
const head = stop.parentNode, next = stop.nextSibling;
let above = null;  // the dialog that is open

function place() {
  back();
  const { left, top, width, height } = stop.getBoundingClientRect();
  head.style.minHeight = `${head.offsetHeight}px`;  // nothing moves while it is away
  above.append(stop);
  Object.assign(stop.style, { position: "fixed", left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px`, right: "auto", bottom: "auto" });
}

function back() {
  head.insertBefore(stop, next);
  head.style.minHeight = "";
  Object.assign(stop.style, { position: "", left: "", top: "", width: "", height: "", right: "", bottom: "" });
}

let ended = () => {};  // of the dialog that is open, however it ends

function end(dialog) {
  if (above !== dialog) return;
  above = null;
  if (window.HTMLDialogElement) back();
  ended();
}

// `then()`: it has been closed, by whatever.
export function open(dialog, then = () => {}) {
  shut();
  dialog.showModal();
  above = dialog;
  ended = then;
  if (window.HTMLDialogElement) place();  // else nothing is out of reach
  dialog.onclose = () => { if (!dialog.open) end(dialog); };  // it may have been opened anew before it is told
}

// Close the dialog that is open.
export function shut() {
  const dialog = above;
  if (!dialog) return;
  dialog.close();
  end(dialog);
}

addEventListener("resize", () => { if (above && window.HTMLDialogElement) place(); });
