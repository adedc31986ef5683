// Serves a folder until it is ended, and says where: for programs that look at a built site from outside.
import { served } from "./browser.mjs";

const { root } = await served(process.argv[2]);
console.log(root);
