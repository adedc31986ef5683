// Where the browser keeps what one has done; null where it keeps nothing.

export const storage: Storage | null = (() => {
  try {
    return window.localStorage;
  } catch {
    return null; // a browser that keeps nothing
  }
})();
