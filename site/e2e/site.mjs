// The built site for the tests of practising: what its bank holds.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { builtSite, served as servedFolder } from "../tools/browser.mjs";

/** How to read of the bank of a built site, and the right answer to a question about the planar arm, as it is typed. */
export function bankOf(folder) {
  const bank = (name) => JSON.parse(readFileSync(join(folder, `bank/${name}.json`), "utf8"));
  return { bank, typed: (kind) => bank(`planar-2r/001/${kind}`).solved.typed };
}

/** The site on a server of its own: its folder, its address, its bank, and how to end it all. */
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
