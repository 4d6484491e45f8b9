// What this browser keeps of a study: on its disk before it counts as kept.

const STORE = "kept";

/** The browser's store; an Error in one line where it keeps nothing. */
export async function openKept(name = "overview-study") {
  if (!globalThis.indexedDB) throw new Error("this browser keeps nothing: no IndexedDB");
  const opening = indexedDB.open(name, 1);
  opening.onupgradeneeded = () => opening.result.createObjectStore(STORE);
  try {
    return new Kept(await answered(opening));
  } catch (error) {
    throw new Error(`this browser keeps nothing (a private window?): ${error.message}`);
  }
}

export class Kept {
  constructor(database) {
    this.database = database;
  }

  /** Keep a value; the promise is of when it is on the disk. */
  put(key, value) {
    return this.written((store) => store.put(value, key));
  }

  /** The value of a key; undefined without one. */
  get(key) {
    return answered(this.store("readonly").get(key));
  }

  /** [key, value] of all keys that begin so, in their order. */
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
    // strict: told only once the disk has it, not merely the operating system
    return this.database.transaction(STORE, mode, { durability: "strict" }).objectStore(STORE);
  }

  /** @returns {Promise<void>} */
  written(act) {
    return new Promise((resolve, reject) => {
      const store = this.store("readwrite");
      act(store);
      store.transaction.oncomplete = () => resolve();
      store.transaction.onabort = () =>
        reject(new Error(`this browser can't keep the answer: ${store.transaction.error?.message}`));
    });
  }
}

const answered = (request) =>
  new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
