// @vitest-environment happy-dom
// Terms of formulas as MathML: where they end, which joint their letters are about, and what is read of them.

import { describe, expect, it } from "vitest";

import { parse } from "../../src/read/reader.js";
import { evaluateRealTree } from "../../src/read/real.js";
import { armOf } from "../../src/arm/model.js";
import { termAfterKey } from "../../src/arm/formula-keys.js";
import { jointOf, symbolsOf, termAt, termsOf, typedText } from "../../src/arm/terms.js";
import { PLAIN } from "./robots.js";

const ARM = armOf(PLAIN);
const sub = (letter: string, index: string): string => `<msub><mi>${letter}</mi><mn>${index}</mn></msub>`;
const sum = [sub("a", "1"), sub("c", "1"), "<mo>+</mo>", sub("a", "2"), sub("c", "12")].join("");

function formula(inner: string): Element {
  document.body.innerHTML = `<main><math><mrow>${inner}</mrow></math></main>`;
  return document.querySelector("math")!;
}
const symbol = (math: Element, index: number): Element => math.querySelectorAll("msub, msubsup")[index]!;
const words = (parts: readonly Element[]): string => parts.map((part) => part.textContent).join("");

describe("a term", () => {
  it("lies between signs, with all of its factors", () => {
    const math = formula(`<mi>x</mi><mo>=</mo>${sum}`);
    expect(words(termAt(symbol(math, 0)))).toBe("a1c1");
    expect(words(termAt(symbol(math, 3)))).toBe("a2c12");
    expect(words(termAt(symbol(math, 3).querySelector("mn")!))).toBe("a2c12");
  });

  it("contains a bracket as a factor; inside the bracket, the inner term is found", () => {
    const math = formula(`${sub("c", "1")}<mo>(</mo>${sum}<mo>)</mo><mo>−</mo>${sub("d", "1")}`);
    expect(words(termAt(symbol(math, 0)))).toBe("c1(a1c1+a2c12)");
    expect(words(termAt(symbol(math, 4)))).toBe("a2c12");
    expect(words(termAt(symbol(math, 5)))).toBe("d1");
  });

  it("is the content of a matrix cell", () => {
    const math = formula(`<mtable><mtr><mtd>${sub("c", "1")}</mtd><mtd>${sub("s", "12")}</mtd></mtr></mtable>`);
    expect(words(termAt(symbol(math, 1)))).toBe("s12");
  });

  it("is not found at a sign between terms", () => {
    expect(termAt(formula("<mo>=</mo>").querySelector("mo")!)).toEqual([]);
  });
});

describe("the joint of a symbol", () => {
  it("is that of the index for angles, lengths and columns, and the next one for axes", () => {
    const joint = (inner: string): number | null => jointOf(symbol(formula(inner), 0), ARM);
    for (const letter of ["θ", "c", "s", "a", "d", "J"]) expect(joint(sub(letter, "2"))).toBe(1);
    expect(joint(sub("c", "12"))).toBe(1);
    expect(joint(sub("z", "0"))).toBe(0);
    expect(joint(`<msub><mover><mi>θ</mi><mo>˙</mo></mover><mn>1</mn></msub>`)).toBe(0);
    for (const other of [sub("a", "3"), sub("O", "1"), sub("a", "0"), `<msub><mi>θ</mi><mi>i</mi></msub>`])
      expect(joint(other)).toBe(null);
  });

  it("leads back to its symbols, outside the arm's own letters", () => {
    formula(sum);
    document.querySelector("main")!.innerHTML += `<div class="arm"><math>${sub("a", "2")}</math></div>`;
    expect(symbolsOf(document, 1, ARM).map(({ textContent }) => textContent)).toEqual(["a2", "c12"]);
  });
});

describe("the text of a term", () => {
  const cases: readonly (readonly [inner: string, text: string | null])[] = [
    [`${sub("a", "2")}${sub("c", "12")}`, "a2*c12"],
    [`<mrow><mi>sin</mi><mo>\u2061</mo><mspace></mspace></mrow>${sub("θ", "1")}`, "sin(theta1)"],
    [`<mi>sin</mi><mo>\u2061</mo><mspace></mspace>${sub("θ", "1")}`, "sin(theta1)"],
    [
      `${sub("a", "1")}<mi>cos</mi><mo>(</mo>${sub("θ", "1")}<mo>+</mo>${sub("θ", "2")}<mo>)</mo>`,
      "a1*cos(theta1+theta2)",
    ],
    [`<mfrac>${sub("a", "1")}<mn>2</mn></mfrac>${sub("s", "2")}`, "((a1)/(2))*s2"],
    [`<msubsup><mi>c</mi><mn>1</mn><mn>2</mn></msubsup>`, "(c1)^(2)"],
    [`<msqrt>${sub("a", "1")}</msqrt>`, "sqrt(a1)"],
    [`<mrow>${sum}</mrow>${sub("s", "1")}`, "(a1*c1+a2*c12)*s1"],
    [`<mn>0,5</mn>${sub("a", "1")}`, "0.5*a1"],
    [`${sub("a", "1")}<msub><mover><mi>θ</mi><mo>˙</mo></mover><mn>1</mn></msub>`, "a1*qd1"],
    [`<msubsup><mover><mi>θ</mi><mo>˙</mo></mover><mn>2</mn><mn>2</mn></msubsup>`, "(qd2)^(2)"],
    [`<mtext>so</mtext>${sub("a", "1")}`, null],
  ];

  it.each(cases)("%s", (inner, text) => {
    const row = formula(inner).firstElementChild!;
    expect(typedText([...row.children])).toBe(text);
  });

  it("has the same value as the term", () => {
    const names = ["theta1", "theta2", "a1", "a2"];
    const at = { theta1: 0.3, theta2: -1.1, a1: 0.5, a2: 0.4 };
    const row = formula(sum).firstElementChild!;
    const value = evaluateRealTree(parse(typedText([...row.children])!, new Set(names)), at);
    expect(value).toBeCloseTo(0.5 * Math.cos(0.3) + 0.4 * Math.cos(-0.8), 12);
  });
});

describe("keys", () => {
  const math = (): Element =>
    formula(`<mi>x</mi><mo>=</mo>${sub("c", "1")}<mo>(</mo>${sum}<mo>)</mo><mo>−</mo>${sub("d", "1")}`);

  it("find all terms, one with a bracket before those inside it", () => {
    expect(termsOf(math()).map(words)).toEqual(["x", "c1(a1c1+a2c12)", "a1c1", "a2c12", "d1"]);
  });

  it("move from term to term, to a term's letters and back, and stop at the ends", () => {
    const whole = math();
    let parts: readonly Element[] | null = null;
    const after = (key: string): string => words((parts = termAfterKey(whole, parts, key))!);
    expect(["Home", "ArrowRight", "ArrowRight", "ArrowRight"].map(after)).toEqual([
      ...["x", "c1(a1c1+a2c12)", "a1c1", "a2c12"],
    ]);
    expect(["ArrowDown", "ArrowDown", "ArrowDown", "ArrowUp", "ArrowUp"].map(after)).toEqual([
      ...["a2", "c12", "c12", "a2", "a2c12"],
    ]);
    expect(["ArrowDown", "ArrowRight", "ArrowRight", "ArrowLeft"].map(after)).toEqual(["a2", "d1", "d1", "a2c12"]);
    expect(after("End")).toBe("d1");
    expect(termAfterKey(whole, parts, "Tab")).toBeNull();
  });
});
