// Link the page's formulas to the arm: pointing at a term lights its link, angle or column and shows its value;
// pointing at a link lights its letters. Keys reach the same terms (formula-keys.ts).

import type { JSX } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";

import { read } from "../read/reader.js";
import { realValue } from "../read/real.js";
import { inDigits, say } from "../text/text.js";
import { stepped, useFormulaStops } from "./formula-keys.js";
import { namedPose, type State } from "./model.js";
import { stationOn } from "./path.js";
import { angleIn, digits } from "./speech.js";
import type { Stage } from "./stage.js";
import { jointOf, SYMBOL, symbolsIn, symbolsOf, termAt, typed } from "./terms.js";
import { jointClass } from "./letters.js";

/** A term that is pointed at, whether it stays when pointer and focus leave, and whether keys led to it. */
type Term = { readonly parts: readonly Element[]; readonly stays: boolean; readonly byKey?: boolean };

/** How far the middle of a number keeps from the page's sides (pixels). */
const EDGE = 64;

/** What an event is about: a term of a formula that is no part of an arm, with the symbol under the pointer. */
function pointedAt({ target }: Event): { parts: readonly Element[]; symbol: Element | null } | null {
  if (!(target instanceof Element) || !target.closest("main math") || target.closest(".arm")) return null;
  const parts = target.localName === "math" ? [] : termAt(target);
  return parts.length > 0 ? { parts, symbol: target.closest(SYMBOL) ?? onlySymbol(parts) } : null;
}

/** The only symbol with an index in a term, if there is one alone. */
function onlySymbol(parts: readonly Element[]): Element | null {
  const found = symbolsIn(parts);
  return found.length === 1 ? found[0]! : null;
}

/** The number beside a term, and the letters that are lit, while the arm of this stage is on the page. */
export function Answering({ stage, radians, rates }: Omit<ValueProps, "parts">): JSX.Element {
  const help = useId();
  const [term, setTerm] = useState<Term | null>(null);
  const [, setScrolled] = useState(0);
  const { arm, point, lit } = stage;
  const isOurs = useRef(false); // whether the joint that is lit is lit by a formula
  const isResting = useRef(false); // the pointer, since keys lead
  const now = useRef(term);
  now.current = term;
  useFormulaStops(arm, help);

  useEffect(() => {
    const over = new AbortController();
    const listen = (name: string, listener: (event: Event) => void): void =>
      document.addEventListener(name, listener, { signal: over.signal, passive: true });
    const light = (next: Term | null, symbol: Element | null | undefined): void => {
      setTerm(next);
      const joint = symbol ? jointOf(symbol, arm) : null;
      if (joint !== null || isOurs.current) point(joint);
      isOurs.current = joint !== null;
    };
    const show = (event: Event, stays: boolean): void => {
      const found = pointedAt(event);
      light(found && { parts: found.parts, stays }, found?.symbol);
    };
    /** Keys go on from the term that is lit in this formula, and from the first where there is none. */
    const step = (math: Element, key: string): boolean => {
      const from = now.current && math.contains(now.current.parts[0]!) ? now.current.parts : null;
      const parts = key === "Enter" ? from : stepped(math, from, key);
      if (!parts) return false;
      const stays = key === "Enter" && !now.current?.stays;
      light(
        { parts, stays, byKey: true },
        symbolsIn(parts).find((symbol) => jointOf(symbol, arm) !== null),
      );
      return true;
    };
    listen("pointermove", (event) => {
      const { movementX, movementY } = event as PointerEvent;
      if (movementX !== 0 || movementY !== 0) isResting.current = false;
    });
    listen("pointerover", (event) => {
      const isPagesMove = isResting.current && now.current?.byKey; // which a key has scrolled below the pointer
      if (!now.current?.stays && !isPagesMove) show(event, false);
    });
    listen("click", (event) => {
      const found = pointedAt(event);
      if (found || (now.current && !(event.target as Element).closest(".arm"))) show(event, found !== null);
    });
    listen("focusin", ({ target }) => {
      if (isFormula(target) && target.matches(":focus-visible")) step(target, "Home");
    });
    listen("focusout", ({ target }) => {
      if (isFormula(target) && now.current?.byKey && !now.current.stays) light(null, null);
    });
    const pressed = (event: KeyboardEvent): void => {
      const { key, target, ctrlKey, metaKey, altKey } = event;
      if (key === "Escape" && now.current) light(null, null);
      else if (isFormula(target) && !ctrlKey && !metaKey && !altKey && step(target, key)) event.preventDefault();
    };
    document.addEventListener("keydown", pressed, { signal: over.signal });
    addEventListener("scroll", () => now.current && setScrolled(scrollY), { signal: over.signal, passive: true });
    return () => over.abort();
  }, [arm, point]);

  useEffect(() => {
    for (const part of term?.parts ?? []) part.classList.add("term-on");
    return () => {
      for (const part of term?.parts ?? []) part.classList.remove("term-on");
    };
  }, [term]);

  useEffect(() => {
    if (lit === null) return;
    const names = ["term-lit", jointClass(lit)];
    const symbols = symbolsOf(document.querySelector("main") ?? document, lit, arm);
    for (const symbol of symbols) symbol.classList.add(...names);
    return () => {
      for (const symbol of symbols) symbol.classList.remove(...names);
    };
  }, [lit, arm]);

  return (
    <>
      <p id={help} class="arm-unseen">
        {say("arm.term.keys")}
      </p>
      <p class="arm-unseen" role="status">
        {term?.byKey ? <Spelled {...{ stage, radians, rates }} parts={term.parts} /> : null}
      </p>
      {term ? <Value {...{ stage, radians, rates }} parts={term.parts} /> : null}
    </>
  );
}

/** A formula that keys have got to. */
function isFormula(target: EventTarget | null): target is Element {
  return target instanceof Element && target.localName === "math" && target.hasAttribute("tabindex");
}

interface ValueProps {
  readonly parts: readonly Element[];
  readonly stage: Stage;
  readonly radians: boolean;
  /** Rates of the joints in a pose, where the page knows them. */
  readonly rates?: ((state: State) => readonly number[]) | undefined;
}

/** A term by its letters and its number, for who does not see which is lit. */
function Spelled(props: ValueProps): JSX.Element {
  const name = spelled(typed(props.parts) ?? props.parts.map(({ textContent }) => textContent).join(" "));
  const value = useShown(props);
  return <>{value === null ? name : say("arm.term.spelled", { name, value })}</>;
}

/** What is typed of a term as it is said: a1 sin θ1, with the rate of a joint by its letter. */
const spelled = (text: string): string =>
  text
    .replaceAll("*", " ")
    .replaceAll("theta", "θ")
    .replace(/\bqd(\d+)/g, "q̇$1");

/** The number of a term at the pose, as it is shown; null where it can't be told. */
function useShown({ parts, stage, radians, rates }: ValueProps): string | null {
  const text = typed(parts);
  const value = text === null ? null : valueOf(text, stage, rates);
  if (value === null || !parts[0]!.isConnected) return null;
  const isAngle = /^theta\d+$/.test(text!);
  return isAngle ? `${inDigits(angleIn(radians, value))}${radians ? "" : "°"}` : inDigits(digits(value));
}

/** What a term is at the pose, below it; nothing where it can't be told. */
function Value(props: ValueProps): JSX.Element | null {
  const value = useShown(props);
  if (value === null) return null;
  const boxes = props.parts.map((part) => part.getBoundingClientRect());
  const bottom = Math.max(...boxes.map((box) => box.bottom));
  const middle = (boxes[0]!.left + boxes.at(-1)!.right) / 2;
  const left = Math.max(EDGE, Math.min(middle, innerWidth - EDGE));
  return (
    <div class="arm-term" style={{ left: `${left}px`, top: `${bottom + 4}px` }} aria-hidden="true">
      {say("arm.term", { value })}
    </div>
  );
}

/** The value of a term at the stage's pose, on its path if it has one; null without a letter that is known. */
function valueOf(text: string, stage: Stage, ratesIn: ValueProps["rates"]): number | null {
  const { arm, robot, pose } = stage;
  const rates = ratesIn?.(stage.state) ?? ratesOnPath(stage);
  const values = {
    ...robot.values,
    ...namedPose(arm, pose),
    ...Object.fromEntries(rates.map((rate, i) => [`qd${i + 1}`, rate])),
  };
  if (!/[a-z]/.test(text)) return null;
  try {
    const value = realValue(read(text, new Set(Object.keys(values))), values);
    return Number.isFinite(value) ? value : null;
  } catch {
    return null; // a letter of something else
  }
}

/** The rates of the joints where the arm stands on a path; none where there is no path. */
function ratesOnPath({ welding }: Stage): readonly number[] {
  if (!welding) return [];
  const { journey, place, weld } = welding;
  return stationOn(journey, place).slopes.map((slope) => slope * weld.speed);
}
