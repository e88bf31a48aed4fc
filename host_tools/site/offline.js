// Keeps the page's files in this browser, where that is allowed: at 127.0.0.1 and over HTTPS.

if (window.isSecureContext && "serviceWorker" in navigator) navigator.serviceWorker.register("sw.js").catch((error) => console.warn(`offline: ${error.message}`));
