// Formulas of the page answer to the arm: what is pointed at lights its link, its angle or its column, and has its value at
// the pose, which follows the arm where it was clicked; and a link that is pointed at lights its letters.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { read } from "../read/reader.js";
import { realValue } from "../read/real.js";
import { angleIn, digits, useDigits, useSay } from "./speech.js";
import type { Stage } from "./stage.js";
import { jointOf, symbolsOf, termAt, typed } from "./terms.js";

/** A term that is pointed at, and whether it stays though the pointer goes. */
interface Term {
  readonly parts: readonly Element[];
  readonly stays: boolean;
}

const SYMBOL = "msub, msubsup";
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
  const found = parts.flatMap((part) => [
    ...(part.matches(SYMBOL) ? [part] : []),
    ...part.querySelectorAll(SYMBOL),
  ]);
  return found.length === 1 ? found[0]! : null;
}

/** The number beside a term, and the letters that are lit, while the arm of this stage is on the page. */
export function Answering({ stage, radians }: { stage: Stage; radians: boolean }): JSX.Element | null {
  const [term, setTerm] = useState<Term | null>(null);
  const [, setScrolled] = useState(0);
  const { arm, point, lit } = stage;
  const isOurs = useRef(false); // whether the joint that is lit is lit by a formula
  const now = useRef(term);
  now.current = term;

  useEffect(() => {
    const over = new AbortController();
    const listen = (name: string, listener: (event: Event) => void): void =>
      document.addEventListener(name, listener, { signal: over.signal, passive: true });
    const show = (event: Event, stays: boolean): void => {
      const found = pointedAt(event);
      setTerm(found && { parts: found.parts, stays });
      const joint = found?.symbol ? jointOf(found.symbol, arm) : null;
      if (joint !== null || isOurs.current) point(joint);
      isOurs.current = joint !== null;
    };
    listen("pointerover", (event) => {
      if (!now.current?.stays) show(event, false);
    });
    listen("click", (event) => {
      const found = pointedAt(event);
      if (found || (now.current && !(event.target as Element).closest(".arm"))) show(event, found !== null);
    });
    listen("keydown", (event) => {
      if ((event as KeyboardEvent).key === "Escape" && now.current) show(event, false);
    });
    addEventListener("scroll", () => now.current && setScrolled(scrollY), {
      signal: over.signal,
      passive: true,
    });
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
    const names = ["term-lit", `arm-j${(lit % 7) + 1}`];
    const symbols = symbolsOf(document.querySelector("main") ?? document, lit, arm);
    for (const symbol of symbols) symbol.classList.add(...names);
    return () => {
      for (const symbol of symbols) symbol.classList.remove(...names);
    };
  }, [lit, arm]);

  return term ? <Value parts={term.parts} stage={stage} radians={radians} /> : null;
}

interface ValueProps {
  readonly parts: readonly Element[];
  readonly stage: Stage;
  readonly radians: boolean;
}

/** What a term is at the pose, below it; nothing where it can't be told. */
function Value({ parts, stage, radians }: ValueProps): JSX.Element | null {
  const say = useSay();
  const signed = useDigits();
  const text = typed(parts);
  const value = text === null ? null : valueOf(text, stage);
  if (value === null || !parts[0]!.isConnected) return null;
  const [first, last] = [parts[0]!.getBoundingClientRect(), parts.at(-1)!.getBoundingClientRect()];
  const bottom = Math.max(...parts.map((part) => part.getBoundingClientRect().bottom));
  const left = Math.max(EDGE, Math.min((first.left + last.right) / 2, innerWidth - EDGE));
  const isAngle = /^theta\d+$/.test(text!);
  const shown = isAngle ? `${signed(angleIn(radians, value))}${radians ? "" : "°"}` : signed(digits(value));
  return (
    <output class="arm-term" style={{ left: `${left}px`, top: `${bottom + 4}px` }}>
      {say("arm.term", { value: shown })}
    </output>
  );
}

/** A term's value at the stage's pose, with its lengths; null where it has no letter, or one that is not the arm's. */
function valueOf(text: string, { arm, robot, pose }: Stage): number | null {
  const values = {
    ...robot.values,
    ...Object.fromEntries(arm.joints.map(({ name }, i) => [name, pose[i]!])),
  };
  if (!/[a-z]/.test(text)) return null;
  try {
    const value = realValue(read(text, new Set(Object.keys(values))), values);
    return Number.isFinite(value) ? value : null;
  } catch {
    return null; // a letter of something else
  }
}
