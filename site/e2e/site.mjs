// The built site, and the content of its bank, for the tests of the practice page.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { builtSite, served as servedFolder } from "../tools/browser.mjs";

/** Return functions that read the bank of a built site, and right answers about the planar arm as students type them. */
export function bankOf(folder) {
  const bank = (name) => JSON.parse(readFileSync(join(folder, `bank/${name}.json`), "utf8"));
  return { bank, typed: (kind) => bank(`planar-2r/001/${kind}`).solved.typed };
}

/** Serve the site; return its folder, its address, its bank, and how to stop the server. */
export async function served() {
  const { folder, remove } = builtSite();
  const { root, close } = await servedFolder(folder);
  return {
    folder,
    root,
    ...bankOf(folder),
    close() {
      close();
      remove();
    },
  };
}
