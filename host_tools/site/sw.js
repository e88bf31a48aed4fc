// The service worker: the page's files of one hash. They are asked for at the server first, or taken as they are kept.

const KEPT = "passo-HASH", FIRST = "WHICH";
const FILES = ["NAMES"];

self.addEventListener("install", (event) => {
  event.waitUntil(caches.open(KEPT).then((kept) => kept.addAll(FILES)).then(() => self.skipWaiting()));
});

self.addEventListener("activate", (event) => {
  const old = (name) => name.startsWith("passo-") && name !== KEPT;
  event.waitUntil(caches.keys().then((names) => Promise.all(names.filter(old).map((name) => caches.delete(name)))).then(() => self.clients.claim()));
});

// Only what the page loads: orders and STOP go to the server, or fail.
self.addEventListener("fetch", (event) => {
  const { method, url } = event.request;
  if (method !== "GET" || new URL(url).origin !== location.origin) return;
  const kept = () => caches.open(KEPT).then((files) => files.match(event.request, { ignoreSearch: true }));
  const asked = () => fetch(event.request);
  event.respondWith(FIRST === "cache" ? kept().then((found) => found || asked()) : asked().catch(() => kept().then((found) => found || Response.error())));
});
