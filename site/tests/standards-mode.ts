// Temml typesets only in pages with a doctype, which the documents of happy-dom don't have.
if (typeof document !== "undefined")
  Object.defineProperty(document, "compatMode", { value: "CSS1Compat", configurable: true });
