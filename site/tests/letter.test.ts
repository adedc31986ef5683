// What a symbol's LaTeX is made of.
import { expect, test } from "vitest";

import { parseSymbol } from "../src/practice/letter.js";

test.each([
  ["\\dot{\\theta}_{1}", { letter: "θ", hasDot: true, mark: "", index: "1" }],
  ["p^*_{0}", { letter: "p", hasDot: false, mark: "*", index: "0" }],
  ["\\omega_{2}'", { letter: "ω", hasDot: false, mark: "′", index: "2" }],
  ["v_{x}", { letter: "v", hasDot: false, mark: "", index: "x" }],
  ["x", { letter: "x", hasDot: false, mark: "", index: "" }],
])("%s is shown without typesetting", (latex, parts) => expect(parseSymbol(latex)).toEqual(parts));

test.each(["\\det J_{11}", "|v_P|", "\\kappa^2"])("%s is typeset", (latex) => expect(parseSymbol(latex)).toBeNull());
