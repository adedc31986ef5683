// What the browser stores of the student's work. A browser that stores nothing, or is full, prevents nothing.

export const storage: Storage | null = (() => {
  try {
    return window.localStorage;
  } catch {
    return null; // the browser stores nothing
  }
})();

/** Return the text stored under a key; null if there is none. */
export function storedText(storage: Storage | null, key: string): string | null {
  try {
    return storage?.getItem(key) ?? null;
  } catch {
    return null;
  }
}

export function storeText(storage: Storage | null, key: string, text: string): void {
  try {
    storage?.setItem(key, text);
  } catch {
    // the page works without storage
  }
}

/** Return what is stored under a key as JSON, checked by `check`; without valid content, `check(null)`. */
export function storedJson<T>(storage: Storage | null, key: string, check: (content: unknown) => T): T {
  try {
    return check(JSON.parse(storedText(storage, key) ?? "null"));
  } catch {
    return check(null);
  }
}
