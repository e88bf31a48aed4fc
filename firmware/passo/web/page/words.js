// Words: the English text is its own key; a catalogue has the others. The page's HTML is English.

let catalogue = {};
const texts = new Map();      // text node: what it says in English
const labels = new Map();     // element: its aria-label in English
export const languages = ["en", "pt"];

export const _ = (text, values = {}) =>
  (catalogue[text] || text).replace(/\{(\w+)\}/g, (whole, name) => (name in values ? values[name] : whole));

function collect(root) {
  const walk = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode;
    const text = node.textContent.trim();
    if (/[a-z]{2}/i.test(text) && !node.parentElement.closest("[lang]:not(html), script, [data-as-is]")) texts.set(node, text);
  }
  for (const element of root.querySelectorAll("[aria-label]")) labels.set(element, element.getAttribute("aria-label"));
}

export async function choose(language) {
  if (!texts.size) collect(document.body);
  catalogue = language === "en" ? {} : await (await fetch(`${language}.json`)).json();
  document.documentElement.lang = language;
  for (const [node, text] of texts) node.textContent = node.textContent.replace(node.textContent.trim(), _(text));
  for (const [element, text] of labels) element.setAttribute("aria-label", _(text));
}

export const preferred = () =>
  languages.find((each) => (navigator.languages || [navigator.language]).some((wanted) => wanted.toLowerCase().startsWith(each))) || "en";
