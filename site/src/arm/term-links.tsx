// Link the page's formulas to the arm: pointing at a term highlights its link, angle or column and shows its value;
// pointing at a link highlights its letters. The keyboard reaches the same terms (formula-keys.ts).

import type { JSX } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";

import { parse } from "../read/reader.js";
import { evaluateRealTree } from "../read/real.js";
import { resultOrNull } from "../storage.js";
import { formatNumber, say, withGreek } from "../text/text.js";
import { termAfterKey, useFormulaStops } from "./formula-keys.js";
import { namedPose, type State } from "./model.js";
import { stationOn } from "./path.js";
import { convertAngle, roundToDigits } from "./number-format.js";
import type { Stage } from "./stage.js";
import { jointOf, SYMBOL, symbolsIn, symbolsOf, termAt, typedText } from "./terms.js";
import { jointClass } from "./letters.js";
import { clamp } from "./vector.js";
import { hasModifier } from "./view.js";

/** The highlighted term: its elements, whether a click keeps it highlighted, and whether the keyboard selected it. */
type Term = { readonly parts: readonly Element[]; readonly isPinned: boolean; readonly isByKey?: boolean };

/** Minimum distance in pixels of a shown number from the sides of the window. */
const EDGE_DISTANCE = 64;

/** Return the term under the pointer, outside the arm's panel, and the symbol in it; null if there is none. */
function findPointedTerm({ target }: Event): { parts: readonly Element[]; symbol: Element | null } | null {
  if (!(target instanceof Element) || !target.closest("main math") || target.closest(".arm")) return null;
  const parts = target.localName === "math" ? [] : termAt(target);
  const symbols = symbolsIn(parts);
  const onlySymbol = symbols.length === 1 ? symbols[0]! : null;
  return parts.length > 0 ? { parts, symbol: target.closest(SYMBOL) ?? onlySymbol } : null;
}

/** Show the number of the highlighted term, and highlight the letters of the joint that is pointed at. */
export function TermLinks({ stage, inRadians, rates }: Omit<ValueProps, "parts">): JSX.Element {
  const help = useId();
  const [term, setTerm] = useState<Term | null>(null);
  const [, setScrolled] = useState(0);
  const { arm, highlight, highlightedJoint } = stage;
  const hasFormulaHighlight = useRef(false); // whether a formula, not the drawing, highlighted the joint
  const isPointerResting = useRef(false); // whether the pointer rests while the keyboard is used
  const currentTerm = useRef(term);
  currentTerm.current = term;
  useFormulaStops(arm, help);

  useEffect(() => {
    const controller = new AbortController();
    const listen = (name: string, listener: (event: Event) => void): void =>
      document.addEventListener(name, listener, { signal: controller.signal, passive: true });
    const highlightTerm = (next: Term | null, symbol: Element | null | undefined): void => {
      setTerm(next);
      const joint = symbol ? jointOf(symbol, arm) : null;
      if (joint !== null || hasFormulaHighlight.current) highlight(joint);
      hasFormulaHighlight.current = joint !== null;
    };
    const show = (event: Event, isPinned: boolean): void => {
      const pointedTerm = findPointedTerm(event);
      highlightTerm(pointedTerm && { parts: pointedTerm.parts, isPinned }, pointedTerm?.symbol);
    };
    /** Highlight the term to which a key leads in a formula; return whether the key was used. */
    const moveByKey = (math: Element, key: string): boolean => {
      const highlightedParts =
        currentTerm.current && math.contains(currentTerm.current.parts[0]!) ? currentTerm.current.parts : null;
      const parts = key === "Enter" ? highlightedParts : termAfterKey(math, highlightedParts, key);
      if (!parts) return false;
      const isPinned = key === "Enter" && !currentTerm.current?.isPinned;
      highlightTerm(
        { parts, isPinned, isByKey: true },
        symbolsIn(parts).find((symbol) => jointOf(symbol, arm) !== null),
      );
      return true;
    };
    listen("pointermove", (event) => {
      const { movementX, movementY } = event as PointerEvent;
      if (movementX !== 0 || movementY !== 0) isPointerResting.current = false;
    });
    listen("pointerover", (event) => {
      const hasPageScrolled = isPointerResting.current && currentTerm.current?.isByKey; // the page moved under a resting pointer
      if (!currentTerm.current?.isPinned && !hasPageScrolled) show(event, false);
    });
    listen("click", (event) => {
      const pointedTerm = findPointedTerm(event);
      if (pointedTerm || (currentTerm.current && !(event.target as Element).closest(".arm")))
        show(event, pointedTerm !== null);
    });
    listen("focusin", ({ target }) => {
      if (isFormula(target) && target.matches(":focus-visible")) moveByKey(target, "Home");
    });
    listen("focusout", ({ target }) => {
      if (isFormula(target) && currentTerm.current?.isByKey && !currentTerm.current.isPinned) highlightTerm(null, null);
    });
    const pressKey = (event: KeyboardEvent): void => {
      const { key, target } = event;
      if (key === "Escape" && currentTerm.current) highlightTerm(null, null);
      else if (isFormula(target) && !hasModifier(event) && moveByKey(target, key)) event.preventDefault();
    };
    document.addEventListener("keydown", pressKey, { signal: controller.signal });
    const scrolling = { signal: controller.signal, passive: true };
    addEventListener("scroll", () => currentTerm.current && setScrolled(scrollY), scrolling);
    return () => controller.abort();
  }, [arm, highlight]);

  useEffect(() => {
    for (const part of term?.parts ?? []) part.classList.add("term-on");
    return () => {
      for (const part of term?.parts ?? []) part.classList.remove("term-on");
    };
  }, [term]);

  useEffect(() => {
    if (highlightedJoint === null) return;
    const names = ["term-lit", jointClass(highlightedJoint)];
    const symbols = symbolsOf(document.querySelector("main") ?? document, highlightedJoint, arm);
    for (const symbol of symbols) symbol.classList.add(...names);
    return () => {
      for (const symbol of symbols) symbol.classList.remove(...names);
    };
  }, [highlightedJoint, arm]);

  return (
    <>
      <p id={help} class="arm-unseen">
        {say("arm.term.keys")}
      </p>
      <p class="arm-unseen" role="status">
        {term?.isByKey ? <SpelledTerm {...{ stage, inRadians, rates }} parts={term.parts} /> : null}
      </p>
      {term ? <TermValue {...{ stage, inRadians, rates }} parts={term.parts} /> : null}
    </>
  );
}

/** Return whether an element is a formula that Tab reaches. */
function isFormula(target: EventTarget | null): target is Element {
  return target instanceof Element && target.localName === "math" && target.hasAttribute("tabindex");
}

interface ValueProps {
  readonly parts: readonly Element[];
  readonly stage: Stage;
  readonly inRadians: boolean;
  /** The joint rates at a state of the arm, if the page sets them. */
  readonly rates?: ((state: State) => readonly number[]) | undefined;
}

/** A term by its letters and its number, for a screen reader. */
function SpelledTerm(props: ValueProps): JSX.Element {
  const name = spellOut(typedText(props.parts) ?? props.parts.map(({ textContent }) => textContent).join(" "));
  const value = formatValue(props);
  return <>{value === null ? name : say("arm.term.spelled", { name, value })}</>;
}

/** Return a typed term as it is read aloud: a1 sin θ1; a joint rate has its dot. */
const spellOut = (text: string): string =>
  withGreek(text)
    .replaceAll("*", " ")
    .replace(/\bqd(\d+)/g, "q̇$1");

/** Return the value of a term at the current pose as text; null if it has none. */
function formatValue({ parts, stage, inRadians, rates }: ValueProps): string | null {
  const text = typedText(parts);
  const value = text === null ? null : valueOf(text, stage, rates);
  if (value === null || !parts[0]!.isConnected) return null;
  const isAngle = /^theta\d+$/.test(text!);
  return isAngle
    ? `${formatNumber(convertAngle(inRadians, value))}${inRadians ? "" : "°"}`
    : formatNumber(roundToDigits(value));
}

/** The value of a term, shown below it; nothing if it has none. */
function TermValue(props: ValueProps): JSX.Element | null {
  const value = formatValue(props);
  if (value === null) return null;
  const boxes = props.parts.map((part) => part.getBoundingClientRect());
  const bottom = Math.max(...boxes.map((box) => box.bottom));
  const middle = (boxes[0]!.left + boxes.at(-1)!.right) / 2;
  const left = clamp(middle, EDGE_DISTANCE, innerWidth - EDGE_DISTANCE);
  return (
    <div class="arm-term" style={{ left: `${left}px`, top: `${bottom + 4}px` }} aria-hidden="true">
      {say("arm.term", { value })}
    </div>
  );
}

/** Return the value of a typed term at the stage's pose, with the rates on its path; null if a letter is unknown. */
function valueOf(text: string, stage: Stage, ratesAt: ValueProps["rates"]): number | null {
  const { arm, robot, pose } = stage;
  const rates = ratesAt?.(stage.state) ?? ratesOnPath(stage);
  const values = {
    ...robot.values,
    ...namedPose(arm, pose),
    ...Object.fromEntries(rates.map((rate, i) => [`qd${i + 1}`, rate])),
  };
  if (!/[a-z]/.test(text)) return null;
  // a term with letters of something else has no value
  const value = resultOrNull(() => evaluateRealTree(parse(text, new Set(Object.keys(values))), values));
  return Number.isFinite(value) ? value : null;
}

/** Return the joint rates at the arm's place on the welding path; an empty list without a path. */
function ratesOnPath({ welding }: Stage): readonly number[] {
  if (!welding) return [];
  const { journey, place, weld } = welding;
  return stationOn(journey, place).slopes.map((slope) => slope * weld.speed);
}
