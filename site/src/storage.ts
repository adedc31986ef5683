// Load and store the student's work in the browser. If the browser stores nothing, or is full, the page works without.

/** Return the result of a function; null if it is null or undefined, or if the function throws. */
export function resultOrNull<T>(attempt: () => T): NonNullable<T> | null {
  try {
    return attempt() ?? null;
  } catch {
    return null;
  }
}

export const storage: Storage | null = resultOrNull(() => window.localStorage);

/** Return the text stored under a key; null if there is none. */
export const loadText = (storage: Storage | null, key: string): string | null =>
  resultOrNull(() => storage?.getItem(key));

export const storeText = (storage: Storage | null, key: string, text: string): void =>
  void resultOrNull(() => storage?.setItem(key, text));

/** Return what is stored under a key as JSON, checked by `check`; without valid content, `check(null)`. */
export const loadJson = <T>(storage: Storage | null, key: string, check: (content: unknown) => T): T =>
  resultOrNull(() => check(JSON.parse(loadText(storage, key) ?? "null"))) ?? check(null);
