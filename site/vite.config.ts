// Builds the scripts and styles that every page of the site loads; the pages themselves are rendered by Python.
import preact from "@preact/preset-vite";
import { defineConfig } from "vite";

export default defineConfig({
  base: "./",
  plugins: [preact()],
  build: {
    outDir: "dist",
    manifest: true, // by which Python knows the names of the files
    rollupOptions: { input: { practice: "src/practice/main.tsx", pages: "src/pages/main.ts" } },
  },
});
