// Begins each file of tests with an empty page that typesets formulas.
import { render } from "preact";

if (typeof document !== "undefined") {
  // Temml typesets only in pages with a doctype, which the documents of happy-dom don't have.
  Object.defineProperty(document, "compatMode", { value: "CSS1Compat", configurable: true });
  render(null, document.body); // files share a document, and an earlier one may have left something in it
  document.body.replaceChildren();
}
