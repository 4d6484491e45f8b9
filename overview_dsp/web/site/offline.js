// Keep the page in this browser, so that it works without a network; the file list is the export's.

export async function keepOffline() {
  if (!("serviceWorker" in navigator) || !window.isSecureContext) return;
  try {
    await navigator.serviceWorker.register(new URL("./worker.js", import.meta.url));
  } catch (error) {
    console.info(`not kept for use without a network: ${error.message}`);
  }
}
