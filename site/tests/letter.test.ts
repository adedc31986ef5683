// What a symbol's LaTeX is made of.
import { expect, test } from "vitest";

import { parseSymbol } from "../src/practice/letter.js";

test.each([
  ["\\dot{\\theta}_{1}", { letter: "θ", dotted: true, mark: "", index: "1" }],
  ["p^*_{0}", { letter: "p", dotted: false, mark: "*", index: "0" }],
  ["\\omega_{2}'", { letter: "ω", dotted: false, mark: "′", index: "2" }],
  ["v_{x}", { letter: "v", dotted: false, mark: "", index: "x" }],
  ["x", { letter: "x", dotted: false, mark: "", index: "" }],
])("%s is shown without typesetting", (latex, parts) => expect(parseSymbol(latex)).toEqual(parts));

test.each(["\\det J_{11}", "|v_P|", "\\kappa^2"])("%s is typeset", (latex) => expect(parseSymbol(latex)).toBeNull());
