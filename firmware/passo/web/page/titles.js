// What controls do, in a sentence each: their titles, which a pointer shows and a screen reader says. While a control is grey its title says why.
//
//     explain(sentences);     // sentences(): [[selector, text]], the first that fits, in the language of now
//     showTitles(true);           // after a change of language

const CONTROLS = "button, input, select, textarea, summary, canvas, a[href], [tabindex]";
const PAUSE_MS = 300;
let sentences = () => [];

// Of all controls, and again of those that come.
export function explain(of) {
  sentences = of;
  showTitles(true);
  let waits = 0;
  new MutationObserver(() => { waits = waits || setTimeout(() => { waits = 0; showTitles(false); }, PAUSE_MS); }).observe(document.body, { childList: true, subtree: true });
}

// `anew`: also of those that have one.
export function showTitles(anew) {
  const controls = [...document.querySelectorAll(CONTROLS)].filter((control) => anew || !control.dataset.help);
  if (!controls.length) return;
  const rows = sentences();
  for (const control of controls) {
    const [, text] = rows.find(([selector]) => control.matches(selector)) || [];
    if (!text) continue;
    control.dataset.help = text;
    if (!control.dataset.why) control.title = text;
  }
}
