// Where an answer is given: a field, a grid of entries, numbers with units, letters.

import type { ComponentChildren, JSX } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import type { Part, Problem } from "../bank.js";
import { withPoints } from "../read/points.js";
import { readDue } from "../grade/forms.js";
import { read } from "../read/reader.js";
import { ReadError } from "../read/tree.js";
import { typesetTree } from "../read/typeset.js";
import { useRested } from "../later.js";
import { said, say } from "../text/text.js";
import { Html, Tex } from "./math.js";
import { entriesOf, isUnfinished, matrixText } from "./entries.js";
import { called, Letter } from "./letter.js";
import { MathField, putInto } from "./mathfield.js";

const LETTERS = "ABCDEFGH";

export interface Field {
  readonly problem: Problem;
  readonly part: Part;
  readonly onAnswer: (text: string) => void;
  readonly onCheck: () => void;
}

/** The place for an answer to a part; `onAnswer` is told of it as it is typed. */
export function Answer(field: Field): JSX.Element {
  const { part } = field;
  if ("told" in part.key) return <Letters {...field} />;
  const [rows, columns] = part.shape ?? [1, 1];
  return rows * columns > 1 && rows * columns <= 42 ? (
    <Entries {...field} rows={rows} columns={columns} />
  ) : (
    <Single {...field} {...(rows * columns > 1 ? { shape: [rows, columns] as const } : {})} />
  );
}

// --- formulas ---

interface SingleProps extends Field {
  readonly first?: string;
  /** The shape of a matrix that is typed as text. */
  readonly shape?: readonly [rows: number, columns: number];
}

function Single({ problem, part, onAnswer, onCheck, first = "", shape }: SingleProps) {
  const [text, setText] = useState(first);
  const [math, setMath] = useState(false);
  const set = part.key.type === "configurations";
  const unit = part.key.type === "numbers" ? part.key.units[0] : "";
  const change = (value: string) => {
    setText(value);
    onAnswer(value);
  };
  const toggle = () => {
    if (!math) change(latexOf(text, problem)); // a field for mathematics shows what it can read
    setMath(!math);
  };
  return (
    <Fields problem={problem} part={part} hasSymbols>
      <FormulaField
        label={say("answer.label")}
        value={text}
        onValue={change}
        onEnter={onCheck}
        math={math}
        wide
        goesOn={set ? () => false : shape && ((typed) => isUnfinished(typed, ...shape))}
      />
      {unit ? <span class="unit">{unit}</span> : null}
      {set ? <p class="help">{say("answer.set-help")}</p> : null}
      {shape ? <p class="help">{say(shape[1] > 1 ? "answer.matrix-help" : "answer.vector-help")}</p> : null}
      <Button text={say(math ? "answer.plain" : "answer.math")} onClick={toggle} />
    </Fields>
  );
}

function Entries({ problem, part, onAnswer, onCheck, rows, columns }: Field & { rows: number; columns: number }) {
  const [asText, setAsText] = useState(false);
  const [math, setMath] = useState(false);
  const typed = useRef("");
  const [entries, setEntries] = useState<readonly string[]>(() => Array<string>(rows * columns).fill(""));
  const units = part.key.type === "numbers" ? part.key.units : [];
  const fill = (changed: readonly string[]) => {
    setEntries(changed);
    onAnswer(matrixText(changed, columns));
  };
  if (asText) {
    const back = () => {
      fill(entriesOf(typed.current, rows, columns) ?? entries);
      setAsText(false);
    };
    const told = (text: string) => {
      typed.current = text;
      onAnswer(text);
    };
    const first = matrixText(entries, columns) || typed.current; // a text that is no grid is not lost
    return (
      <>
        <Single {...{ problem, part, onCheck, first }} onAnswer={told} shape={[rows, columns]} />
        <Button text={say("answer.as-entries")} onClick={back} />
      </>
    );
  }
  const change = (index: number, value: string) => fill(entries.with(index, value));
  const toText = () => {
    const text = matrixText(entries, columns) || typed.current;
    typed.current = text;
    onAnswer(text);
    setAsText(true);
  };
  const toggle = () => {
    if (!math) fill(entries.map((entry) => latexOf(entry, problem)));
    setMath(!math);
  };
  const paste = (event: ClipboardEvent) => {
    const whole = entriesOf(event.clipboardData?.getData("text") ?? "", rows, columns);
    if (!whole || math) return;
    event.preventDefault(); // a matrix that is pasted into an entry fills them all
    fill(whole);
  };
  const label = (i: number) =>
    columns === 1
      ? say("answer.component", { row: i + 1 })
      : say("answer.entry", { row: Math.floor(i / columns) + 1, column: (i % columns) + 1 });
  return (
    <Fields problem={problem} part={part} hasSymbols={part.key.type !== "numbers"}>
      <Grid rows={rows} columns={columns} of={part.grid} onPaste={paste}>
        {entries.map((entry, i) => (
          <span class="cell" key={i} onFocusIn={inSight}>
            <FormulaField
              label={label(i)}
              value={entry}
              onValue={(value) => change(i, value)}
              onEnter={onCheck}
              math={math}
            />
            {units[i] ? <span class="unit">{units[i]}</span> : null}
          </span>
        ))}
      </Grid>
      <Button text={say("answer.as-text")} onClick={toText} />
      <Button text={say(math ? "answer.plain" : "answer.math")} onClick={toggle} />
    </Fields>
  );
}

interface GridProps {
  readonly rows: number;
  readonly columns: number;
  /** LaTeX of what rows and columns belong to; the prompt tells it to those who don't see it. */
  readonly of: Part["grid"];
  readonly onPaste: (event: ClipboardEvent) => void;
  readonly children: readonly JSX.Element[];
}

/** Entries as a matrix. */
function Grid({ rows, columns, of: [beside, above], onPaste, children }: GridProps): JSX.Element {
  return (
    <div
      class="grid"
      role="group"
      aria-label={say("answer.label")}
      data-columns={columns}
      data-beside={beside.length > 0 ? "" : undefined}
      data-above={above.length > 0 ? "" : undefined}
      onPaste={onPaste}
      style={{ "--columns": columns, "--rows": rows }}
    >
      <span class="bracket" aria-hidden="true" />
      {above.map((latex, column) => (
        <Belonging key={`above ${column}`} latex={latex} />
      ))}
      {children.flatMap((cell, i) =>
        beside.length > 0 && i % columns === 0
          ? [<Belonging key={`beside ${i}`} latex={beside[i / columns]!} isRow />, cell]
          : [cell],
      )}
    </div>
  );
}

const Belonging = ({ latex, isRow = false }: { latex: string; isRow?: boolean }): JSX.Element => (
  <span class={isRow ? "belonging of-row" : "belonging"} aria-hidden="true">
    <Letter latex={latex} />
  </span>
);

/** Where the grid is scrolled by itself, the entry that is typed is in it with all its room. */
function inSight({ currentTarget }: { readonly currentTarget: HTMLElement }): void {
  const grid = currentTarget.parentElement;
  if (!grid || grid.scrollWidth <= grid.clientWidth) return;
  const [cell, box] = [currentTarget.getBoundingClientRect(), grid.getBoundingClientRect()];
  const named = grid.querySelector(".of-row")?.clientWidth ?? 0; // it stays while the entries go below it
  const [before, behind] = [cell.left - box.left - named - EDGE, cell.right - box.right + EDGE];
  if (before < 0) grid.scrollLeft += before;
  else if (behind > 0) grid.scrollLeft += Math.min(behind, before);
}

/** Pixels that stay free at the side of a grid. */
const EDGE = 12;

interface FormulaFieldProps {
  readonly label: string;
  readonly value: string;
  readonly wide?: boolean;
  readonly math: boolean;
  /** Of a text in lines: whether Enter begins another line instead of checking; Shift and Enter always does. */
  readonly goesOn?: ((text: string) => boolean) | undefined;
  readonly onValue: (text: string) => void;
  readonly onEnter: () => void;
}

/** A field for a formula, as text or as mathematics. */
function FormulaField({ label, value, onValue, onEnter, math, wide = false, goesOn }: FormulaFieldProps) {
  if (math) return <MathField label={label} value={value} onValue={onValue} onEnter={onEnter} />;
  const common = {
    class: wide ? "formula-field wide" : "formula-field",
    "aria-label": label,
    value,
    spellcheck: false,
    autocomplete: "off",
    autocapitalize: "none",
  } as const;
  if (!goesOn)
    return (
      <input
        type="text"
        {...common}
        onInput={(event) => onValue(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") onEnter();
        }}
      />
    );
  return (
    <textarea
      {...common}
      rows={Math.min(MOST_LINES, value.split("\n").length)}
      onInput={(event) => onValue(event.currentTarget.value)}
      onKeyDown={(event) => {
        if (event.key !== "Enter" || event.shiftKey || event.isComposing) return;
        if (goesOn(event.currentTarget.value)) return;
        event.preventDefault();
        onEnter();
      }}
    />
  );
}

/** So many lines of a text are in sight at once. */
const MOST_LINES = 8;

interface FieldsProps extends Pick<Field, "problem" | "part"> {
  readonly hasSymbols: boolean;
  readonly children: ComponentChildren;
}

/** The fields of an answer, and buttons that put symbols where the cursor was last. */
function Fields({ problem, part, hasSymbols, children }: FieldsProps) {
  const place = useRef<HTMLDivElement>(null);
  const last = useRef<Element | null>(null);
  const enter = ({ target }: FocusEvent) => {
    if (target instanceof Element && target.matches(FIELDS)) last.current = target;
  };
  const put = (text: string, latex: string) => {
    const held = last.current?.isConnected ? last.current : place.current?.querySelector(FIELDS);
    if (held instanceof HTMLInputElement || held instanceof HTMLTextAreaElement) {
      held.setRangeText(text, held.selectionStart ?? held.value.length, held.selectionEnd ?? held.value.length, "end");
      held.dispatchEvent(new Event("input", { bubbles: true }));
      held.focus();
    } else if (held) putInto(held, latex);
  };
  // Joints and lengths always; rates, velocities and forces where the question speaks of them.
  const names = Object.entries(problem.symbols).filter(
    ([name, { role, value }]) =>
      value === undefined && (["joint", "length", "angle"].includes(role) || part.names.includes(name)),
  );
  return (
    <div class="answer" ref={place} onFocusIn={enter}>
      {children}
      {hasSymbols ? (
        <div class="symbols" role="group" aria-label={say("answer.symbols")}>
          {names.map(([name, { latex }]) => (
            <button
              type="button"
              key={name}
              title={name}
              aria-label={called(name, latex)}
              onClick={() => put(name, latex)}
            >
              <Letter latex={latex} />
            </button>
          ))}
          {FUNCTIONS.map(([name, text, latex]) => (
            <button type="button" key={name} onClick={() => put(text, latex)}>
              {name}
            </button>
          ))}
        </div>
      ) : null}
    </div>
  );
}

const FIELDS = "input.formula-field, textarea.formula-field, math-field";
const FUNCTIONS = [
  ["sin", "sin(", "\\sin\\left(#?\\right)"],
  ["cos", "cos(", "\\cos\\left(#?\\right)"],
  ["sqrt", "sqrt(", "\\sqrt{#?}"],
  ["pi", "pi", "\\pi"],
] as const;

/** So long a formula can still be looked at; one that some program wrote is only judged. */
const SHOWN = 5000;

/** The answer as it is read, typeset as one types; below Check, which would else jump away while it is pressed. */
export function Preview(props: Pick<Field, "problem" | "part"> & { answer: string }): JSX.Element | null {
  const { answer, problem, part } = props;
  const { type } = part.key;
  const text = type === "configurations" ? answer : withPoints(answer);
  const shown = useRested(text, 150);
  const found = useMemo(() => previewOf(shown, problem, part), [shown, problem, part]);
  if ("told" in part.key) return null;
  return (
    <p class="preview" aria-live="polite">
      {found === null ? null : "latex" in found ? (
        <>
          <span class="muted">{say("answer.read-as")}</span> <Tex latex={found.latex} block />
        </>
      ) : (
        <span class="muted">{found.why}</span>
      )}
    </p>
  );
}

/** A formula that was typed as LaTeX; nothing where it can't be read, which the field could not show. */
function latexOf(text: string, problem: Problem): string {
  const found = previewOf(withPoints(text), problem);
  return found && "latex" in found ? found.latex.replaceAll("{,}", ".") : "";
}

function previewOf(
  text: string,
  problem: Problem,
  part: Part | null = null,
): { latex: string } | { why: string } | null {
  if (!text.trim() || text.length > SHOWN) return null;
  const known = new Set(Object.keys(problem.symbols));
  try {
    return { latex: typesetTree(part ? readDue(text, known, part) : read(text, known), problem.symbols) };
  } catch (error) {
    if (error instanceof ReadError) return { why: said(error.why) };
    throw error;
  }
}

// --- letters ---

function Letters({ problem: { lang }, part, onAnswer }: Field) {
  const options = part.options ?? [];
  const [chosen, setChosen] = useState<readonly (number | null)[]>([]);
  const choose = (now: readonly (number | null)[]) => {
    setChosen(now);
    onAnswer(now.every((each) => each !== null) ? now.map((each) => LETTERS[each as number]).join("") : "");
  };
  if (part.key.type === "matching") {
    const items = part.key.items;
    const now = Array.from({ length: items }, (_, i) => chosen[i] ?? null);
    return (
      <div class="answer">
        <p class="help">{say("answer.choose-each")}</p>
        <ul class="options">
          {options.map((option, i) => (
            <li key={i}>
              <strong>{LETTERS[i]}</strong> <Html html={option} class="option-text" lang={lang} />
            </li>
          ))}
        </ul>
        {now.map((each, i) => (
          <label class="match" key={i}>
            {say("answer.match", { index: i + 1 })}
            <select
              value={each ?? ""}
              onChange={(event) => {
                const value = event.currentTarget.value;
                choose(now.with(i, value === "" ? null : Number(value)));
              }}
            >
              <option value="">{say("answer.choose")}</option>
              {options.map((_, k) => (
                <option key={k} value={k}>
                  {LETTERS[k]}
                </option>
              ))}
            </select>
          </label>
        ))}
      </div>
    );
  }
  const single = part.key.type === "choice";
  return (
    <fieldset class="answer options">
      <legend class="help">
        <span class="visually-hidden">{say("answer.label")}: </span>
        {say(single ? "answer.choose-one" : "answer.choose-all")}
      </legend>
      {options.map((option, i) => (
        <label class="option" key={i}>
          <input
            type={single ? "radio" : "checkbox"}
            name="option"
            checked={chosen.includes(i)}
            onChange={() => {
              const kept = chosen.filter((each) => each !== i);
              choose(single ? [i] : kept.length === chosen.length ? [...chosen, i] : kept);
            }}
          />
          <strong>{LETTERS[i]}</strong> <Html html={option} class="option-text" lang={lang} />
        </label>
      ))}
    </fieldset>
  );
}
