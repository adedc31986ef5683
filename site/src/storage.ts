// What the browser keeps of what one has done; a browser that is full, or keeps nothing, hinders nobody.

export const storage: Storage | null = (() => {
  try {
    return window.localStorage;
  } catch {
    return null; // a browser that keeps nothing
  }
})();

/** The text that is kept under a key; null where there is none. */
export function keptText(storage: Storage | null, key: string): string | null {
  try {
    return storage?.getItem(key) ?? null;
  } catch {
    return null;
  }
}

export function keepText(storage: Storage | null, key: string, text: string): void {
  try {
    storage?.setItem(key, text);
  } catch {
    // it goes on all the same
  }
}

/** What is kept under a key as JSON, as far as `checked` takes it; what it makes of null where there is none. */
export function keptJson<T>(storage: Storage | null, key: string, checked: (content: unknown) => T): T {
  try {
    return checked(JSON.parse(keptText(storage, key) ?? "null"));
  } catch {
    return checked(null);
  }
}
