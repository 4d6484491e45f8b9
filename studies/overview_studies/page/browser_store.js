// Storage in this browser (IndexedDB). A value counts as stored once it is in permanent storage.

const STORE = "kept";

/** Open the store; throws an Error with one line if the browser does not allow storage. */
export async function openBrowserStore(name = "overview-study") {
  if (!globalThis.indexedDB) throw new Error("this browser cannot store answers: IndexedDB is missing");
  const opening = indexedDB.open(name, 1);
  opening.onupgradeneeded = () => opening.result.createObjectStore(STORE);
  try {
    return new BrowserStore(await answered(opening));
  } catch (error) {
    throw new Error(`this browser cannot store answers; avoid private windows: ${error.message}`);
  }
}

export class BrowserStore {
  constructor(database) {
    this.database = database;
  }

  /** Store a value; the promise resolves when it is in permanent storage. */
  put(key, value) {
    return this.written((store) => store.put(value, key));
  }

  /** Return the value of a key, or undefined. */
  get(key) {
    return answered(this.store("readonly").get(key));
  }

  /** Return [key, value] of all keys with a prefix, in order. */
  async entries(prefix) {
    const range = IDBKeyRange.bound(prefix, `${prefix}\uffff`);
    const store = this.store("readonly");
    const [keys, values] = await Promise.all([
      answered(store.getAllKeys(range)), answered(store.getAll(range)),
    ]);
    return keys.map((key, i) => [key, values[i]]);
  }

  remove(key) {
    return this.written((store) => store.delete(key));
  }

  store(mode) {
    // strict: complete only when the data are in permanent storage
    return this.database.transaction(STORE, mode, { durability: "strict" }).objectStore(STORE);
  }

  /** @returns {Promise<void>} */
  written(act) {
    return new Promise((resolve, reject) => {
      const store = this.store("readwrite");
      act(store);
      store.transaction.oncomplete = () => resolve();
      store.transaction.onabort = () =>
        reject(new Error(`this browser cannot store the answer: ${store.transaction.error?.message}`));
    });
  }
}

const answered = (request) =>
  new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
