// Builds the scripts and styles that every page of the site loads; the pages themselves are rendered by Python.
import { existsSync, readFileSync } from "node:fs";
import preact from "@preact/preset-vite";
import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

/** Collects the NOTICE files of what is bundled, which the Apache licence wants handed on. */
function notices(): Plugin {
  return {
    name: "notices",
    generateBundle(_, bundle) {
      const modules = Object.values(bundle).flatMap((file) => (file.type === "chunk" ? file.moduleIds : []));
      const packages = modules.map((id) => /^.*\/node_modules\/(?:@[^/]+\/)?[^/]+/.exec(id)?.[0] ?? "");
      const files = [...new Set(packages)].sort().map((folder) => `${folder}/NOTICE`);
      const texts = files
        .filter((file) => existsSync(file))
        .map((file) => readFileSync(file, "utf-8").trim());
      this.emitFile({ type: "asset", fileName: ".vite/notices.md", source: `${texts.join("\n\n")}\n` });
    },
  };
}

export default defineConfig({
  base: "./",
  plugins: [preact(), notices()],
  server: { fs: { allow: [".."] } }, // the vocabulary of answers lies beside the Python reader
  test: {
    testTimeout: 120_000, // a busy machine fails no test
    include: ["tests/**/*.test.ts"], // e2e/ is Node's own test runner's
    pool: "threads",
    isolate: false, // files share modules, whose loading takes half of the time: what a test sets, it sets back
  },
  build: {
    outDir: "dist",
    manifest: true, // by which Python knows the names of the files
    license: { fileName: ".vite/licences.md" }, // of everything that is bundled
    rollupOptions: {
      input: {
        practice: "src/practice/main.tsx",
        learn: "src/learn/main.tsx",
        own: "src/own/main.tsx",
        course: "src/course/main.tsx",
        package: "src/course/package.tsx",
        pages: "src/pages/main.ts",
      },
    },
  },
});
