// Builds the scripts and styles that every page of the site loads; the pages themselves are rendered by Python.
import preact from "@preact/preset-vite";
import { defineConfig } from "vitest/config";

export default defineConfig({
  base: "./",
  plugins: [preact()],
  server: { fs: { allow: [".."] } }, // the vocabulary of answers is beside the Python parser
  test: {
    testTimeout: 120_000, // long enough for a busy machine
    include: ["tests/**/*.test.ts"], // Node's test runner runs e2e/
    setupFiles: ["tests/blank-page.ts"],
    pool: "threads",
    isolate: false, // files share modules, because loading them takes half of the time; each test resets what it changes
  },
  build: {
    outDir: "dist",
    manifest: true, // Python finds the names of the files in it
    license: { fileName: ".vite/licences.md" }, // licences of all bundled code
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
