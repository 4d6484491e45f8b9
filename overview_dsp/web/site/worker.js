// The service worker: every file of the folder from this browser's own store, first the page and
// the whole timeline, then the windows. A folder that was written again has another version, which
// is fetched whole before it takes over.

importScripts("files.js");

const { version, page, more } = self.FILES;
const NAME = `overview ${self.registration.scope} ${version}`;

self.addEventListener("install", (event) => {
  event.waitUntil(
    caches.open(NAME).then((kept) =>
      kept.addAll(["./", "files.js", ...page].map(fresh)),
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

// the page asks for it once it sounds: ten megabytes shouldn't be in its way
self.addEventListener("message", (event) => {
  if (event.data !== "keep windows") return;
  event.waitUntil(
    caches.open(NAME).then(async (kept) => {
      for (const name of more) {
        if (!(await kept.match(name))) await kept.add(fresh(name));
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
  const kept = await caches.open(NAME);
  return (await kept.match(request, { ignoreSearch: true })) ?? fetch(request);
}
