// Builds the scripts and styles that every page of the site loads; the pages themselves are rendered by Python.
import preact from "@preact/preset-vite";
import { defineConfig } from "vitest/config";

export default defineConfig({
  base: "./",
  plugins: [preact()],
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
        check: "src/check/main.tsx",
        package: "src/course/package.tsx",
        serve: "src/serve/main.ts",
        pages: "src/pages/main.ts",
      },
    },
  },
});
