// Serves a folder until it is stopped, and prints the address, for programs that test a built site from outside.
import { served } from "./browser.mjs";

const { root } = await served(process.argv[2]);
console.log(root);
