// What browsers of 2018 (Chrome 70, Safari 12) lack of what this page uses. A newer one keeps its own.

function lacks(where, name, made) {
  if (!where[name]) Object.defineProperty(where, name, { value: made, configurable: true, writable: true });
}

lacks(Element.prototype, "replaceChildren", function replaceChildren(...children) {
  while (this.firstChild) this.removeChild(this.firstChild);
  this.append(...children);
});

lacks(Object, "fromEntries", (pairs) => {
  const made = {};
  for (const [name, value] of pairs) made[name] = value;
  return made;
});

const read = (blob, how) => new Promise((done, failed) => {
  const reader = new FileReader();
  reader.onload = () => done(reader.result);
  reader.onerror = () => failed(reader.error);
  reader[how](blob);
});

lacks(Blob.prototype, "text", function text() { return read(this, "readAsText"); });
lacks(Blob.prototype, "arrayBuffer", function arrayBuffer() { return read(this, "readAsArrayBuffer"); });

// A dialog without its element: the page behind it can still be reached, but nothing else is lost.
const dialogs = window.HTMLDialogElement ? HTMLDialogElement.prototype : HTMLElement.prototype;
lacks(dialogs, "showModal", function showModal() {
  this.setAttribute("open", "");
  this.setAttribute("role", "dialog");
  this.classList.add("above");
});
lacks(dialogs, "close", function close() { this.removeAttribute("open"); });

// down() when a finger or a mouse button goes down on `element`, up() when it ends, wherever that is.
export function held(element, down, up) {
  element.oncontextmenu = (event) => event.preventDefault();
  if (window.PointerEvent) {
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      down(event);
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) element.addEventListener(name, up);
    return;
  }
  element.addEventListener("touchstart", (event) => { event.preventDefault(); down(event); });
  for (const name of ["touchend", "touchcancel"]) element.addEventListener(name, up);
  element.addEventListener("mousedown", (event) => { if (event.button === 0) down(event); });
  window.addEventListener("mouseup", up);
}
