// Offline use: the service worker stores the files that the export lists.

export async function keepOffline() {
  if (!("serviceWorker" in navigator) || !window.isSecureContext) return;
  try {
    await navigator.serviceWorker.register(new URL("./worker.js", import.meta.url));
  } catch (error) {
    console.info(`not stored for offline use: ${error.message}`);
  }
}
