// The service worker: serves all files of a static folder from the browser's storage. It stores the page
// and the whole timeline first, the windows later. A new version is stored completely before it is used.

importScripts("files.js");

const { version, page, more } = self.FILES;
const NAME = `overview ${self.registration.scope} ${version}`;

self.addEventListener("install", (event) => {
  event.waitUntil(
    caches.open(NAME).then((cache) =>
      cache.addAll(["./", "files.js", ...page].map(fresh)),
    ),
  );
});

self.addEventListener("activate", (event) => {
  event.waitUntil(
    (async () => {
      for (const name of await caches.keys()) {
        if (name.startsWith(`overview ${self.registration.scope} `) && name !== NAME) {
          await caches.delete(name);
        }
      }
      await self.clients.claim();
    })(),
  );
});

// requested when the sound starts, because the windows are large
self.addEventListener("message", (event) => {
  if (event.data !== "keep windows") return;
  event.waitUntil(
    caches.open(NAME).then(async (cache) => {
      for (const name of more) {
        if (!(await cache.match(name))) await cache.add(fresh(name));
      }
    }),
  );
});

self.addEventListener("fetch", (event) => {
  if (event.request.method !== "GET") return;
  event.respondWith(answer(event.request));
});

function fresh(name) {
  return new Request(name, { cache: "reload" });
}

async function answer(request) {
  const cache = await caches.open(NAME);
  return (await cache.match(request, { ignoreSearch: true })) ?? fetch(request);
}
