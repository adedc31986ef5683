// The built site on a server of its own, for the tests of practising.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { builtSite, served as servedFolder } from "../tools/browser.mjs";

/** The folder of the site, its address, how to read of its bank, and how to end it all. */
export async function served() {
  const { folder, remove } = builtSite();
  const { root, close } = await servedFolder(folder);
  const bank = (name) => JSON.parse(readFileSync(join(folder, `bank/${name}.json`), "utf8"));
  return {
    folder,
    root,
    bank,
    /** The right answer to a question about the planar arm, as it is typed. */
    typed: (kind) => bank("planar-2r/001.solutions").parts.find(({ name }) => name === kind).typed,
    close() {
      close();
      remove();
    },
  };
}
