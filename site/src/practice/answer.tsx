// The fields for an answer: a formula, a grid of entries, numbers with units, or letters.

import type { ComponentChildren, JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Button, LITERAL, optionsOf } from "../controls.js";
import { type AskedPart, type AskedProblem, isByLetters } from "../bank.js";
import { readCommasAsPoints } from "../read/points.js";
import { parseAnswer } from "../grade/forms.js";
import { parse } from "../read/reader.js";
import { catchParseError, locateEntry } from "../read/tree.js";
import { typesetTree } from "../read/typeset.js";
import { useDebounced } from "../scheduling.js";
import { textOf, say } from "../text/text.js";
import { Html, Tex } from "./math.js";
import { parseEntries, isUnfinished, writeMatrix } from "./entries.js";
import { nameButton, Letter } from "./letter.js";
import { MathField, insertFormula } from "./mathfield.js";
import { useDraft } from "./visits.js";

const LETTERS = "ABCDEFGH";

interface AnswerProps {
  readonly problem: AskedProblem;
  readonly part: AskedPart;
  /** The text of the answer so far, if the page stores it; else this tab stores what the fields contain. */
  readonly storedText?: string | undefined;
  readonly onAnswer: (text: string) => void;
  readonly onCheck: () => void;
}

/** Return the name under which this tab stores a field; "" if the page stores the answer. */
const nameDraft = ({ problem, part, storedText }: AnswerProps, field: string): string =>
  storedText === undefined ? `${problem.id} ${part.name} ${field}` : "";

/** The fields for an answer to a part; `onAnswer` is called while it is typed. */
export function Answer(props: AnswerProps): JSX.Element {
  const { part } = props;
  if (isByLetters(part.key)) return <Letters {...props} />;
  if (part.key.type === "text") return <Text {...props} />;
  const [rows, columns] = part.shape ?? [1, 1];
  return rows * columns > 1 && rows * columns <= 42 ? (
    <Entries {...props} rows={rows} columns={columns} />
  ) : (
    <Single {...props} {...(rows * columns > 1 ? { shape: [rows, columns] as const } : {})} />
  );
}

/** An answer in words. */
function Text({ onAnswer, storedText = "" }: AnswerProps) {
  const [text, setText] = useState(storedText);
  useEffect(() => onAnswer(text), []);
  return (
    <div class="answer">
      <textarea
        class="words wide"
        rows={6}
        aria-label={say("answer.label")}
        value={text}
        onInput={({ currentTarget }) => {
          setText(currentTarget.value);
          onAnswer(currentTarget.value);
        }}
      />
    </div>
  );
}

interface SingleProps extends AnswerProps {
  readonly initialText?: string;
  /** The shape of a matrix that is typed as text; undefined for other answers. */
  readonly shape?: readonly [rows: number, columns: number];
}

function Single(props: SingleProps) {
  const { problem, part, onAnswer, onCheck, storedText, initialText = storedText ?? "", shape } = props;
  const [text, setText] = useDraft(nameDraft(props, "text"), initialText);
  const [isMath, setMath] = useState(false);
  const isSet = part.key.type === "configurations";
  const unit = part.key.type === "numbers" ? part.key.units[0] : "";
  const changeText = (value: string) => {
    setText(value);
    onAnswer(value);
  };
  useEffect(() => {
    if (text) onAnswer(text);
  }, []);
  const toggle = () => {
    if (!isMath) changeText(writeLatex(text, problem)); // the field for mathematics shows only what can be parsed
    setMath(!isMath);
  };
  return (
    <Fields problem={problem} part={part} hasSymbols={part.key.type !== "numbers"}>
      <span class="cell">
        <FormulaField
          label={say("answer.label")}
          value={text}
          onValue={changeText}
          onEnter={onCheck}
          isMath={isMath}
          isWide
          startsNewLine={isSet ? () => false : shape && ((typed) => isUnfinished(typed, ...shape))}
        />
        {unit ? <span class="unit">{unit}</span> : null}
      </span>
      {isSet ? <p class="help">{say("answer.set-help")}</p> : null}
      {shape ? <p class="help">{say(shape[1] > 1 ? "answer.matrix-help" : "answer.vector-help")}</p> : null}
      <Button text={say(isMath ? "answer.plain" : "answer.math")} onClick={toggle} />
    </Fields>
  );
}

function Entries(props: AnswerProps & { rows: number; columns: number }) {
  const { problem, part, onAnswer, onCheck, storedText = "", rows, columns } = props;
  const [storedEntries] = useState(() => parseEntries(storedText, rows, columns));
  const [isText, setIsText] = useDraft(nameDraft(props, "is text"), storedText.trim() !== "" && !storedEntries);
  const [isMath, setMath] = useState(false);
  const [lastText, setLastText] = useDraft(nameDraft(props, "text"), storedText);
  const [entries, setEntries] = useDraft<readonly string[]>(
    nameDraft(props, "entries"),
    storedEntries ?? Array<string>(rows * columns).fill(""),
  );
  const units = part.key.type === "numbers" ? part.key.units : [];
  const changeEntries = (newEntries: readonly string[]) => {
    setEntries(newEntries);
    onAnswer(writeMatrix(newEntries, columns));
  };
  useEffect(() => {
    if (!isText) onAnswer(writeMatrix(entries, columns));
  }, []);
  if (isText) {
    const showEntries = () => {
      changeEntries(parseEntries(lastText, rows, columns) ?? entries);
      setIsText(false);
    };
    const changeText = (text: string) => {
      setLastText(text);
      onAnswer(text);
    };
    const initialMatrix = writeMatrix(entries, columns) || lastText; // a text that is not a grid is kept
    return (
      <>
        <Single
          {...{ problem, part, onCheck, storedText: props.storedText }}
          initialText={initialMatrix}
          onAnswer={changeText}
          shape={[rows, columns]}
        />
        <Button text={say("answer.as-entries")} onClick={showEntries} />
      </>
    );
  }
  const changeEntry = (index: number, value: string) => changeEntries(entries.with(index, value));
  const showText = () => {
    const text = writeMatrix(entries, columns) || lastText;
    setLastText(text);
    onAnswer(text);
    setIsText(true);
  };
  const toggle = () => {
    if (!isMath) changeEntries(entries.map((entry) => writeLatex(entry, problem)));
    setMath(!isMath);
  };
  const pasteMatrix = (event: ClipboardEvent) => {
    const pasted = parseEntries(event.clipboardData?.getData("text") ?? "", rows, columns);
    if (!pasted || isMath) return;
    event.preventDefault(); // a matrix that is pasted into an entry fills them all
    changeEntries(pasted);
  };
  const describeEntry = (i: number) =>
    say(columns === 1 ? "answer.component" : "answer.entry", locateEntry(i, columns));
  return (
    <Fields problem={problem} part={part} hasSymbols={part.key.type !== "numbers"}>
      <Grid rows={rows} columns={columns} labels={part.grid} onPaste={pasteMatrix}>
        {entries.map((entry, i) => (
          <span class="cell" key={i} onFocusIn={scrollToCell}>
            <FormulaField
              label={describeEntry(i)}
              value={entry}
              onValue={(value) => changeEntry(i, value)}
              onEnter={onCheck}
              isMath={isMath}
            />
            {units[i] ? <span class="unit">{units[i]}</span> : null}
          </span>
        ))}
      </Grid>
      <Button text={say("answer.as-text")} onClick={showText} />
      <Button text={say(isMath ? "answer.plain" : "answer.math")} onClick={toggle} />
    </Fields>
  );
}

interface GridProps {
  readonly rows: number;
  readonly columns: number;
  /** LaTeX of the labels of rows and columns; for screen readers, the prompt says the same. */
  readonly labels: AskedPart["grid"];
  readonly onPaste: (event: ClipboardEvent) => void;
  readonly children: readonly JSX.Element[];
}

/** Entries as a matrix. */
function Grid({ rows, columns, labels: [rowLabels, columnLabels], onPaste, children }: GridProps): JSX.Element {
  return (
    <div
      class="grid"
      role="group"
      aria-label={say("answer.label")}
      data-columns={columns}
      data-beside={rowLabels.length > 0 ? "" : undefined}
      data-above={columnLabels.length > 0 ? "" : undefined}
      onPaste={onPaste}
      style={{ "--columns": columns, "--rows": rows }}
    >
      <span class="bracket" aria-hidden="true" />
      {columnLabels.map((latex, column) => (
        <GridLabel key={`above ${column}`} latex={latex} />
      ))}
      {children.flatMap((cell, i) =>
        rowLabels.length > 0 && i % columns === 0
          ? [<GridLabel key={`beside ${i}`} latex={rowLabels[i / columns]!} isRow />, cell]
          : [cell],
      )}
    </div>
  );
}

const GridLabel = ({ latex, isRow = false }: { latex: string; isRow?: boolean }): JSX.Element => (
  <span class={isRow ? "belonging of-row" : "belonging"} aria-hidden="true">
    <Letter latex={latex} />
  </span>
);

/** If the grid is scrolled, scroll the entry with the focus into it completely. */
function scrollToCell({ currentTarget }: { readonly currentTarget: HTMLElement }): void {
  const grid = currentTarget.parentElement;
  if (!grid || grid.scrollWidth <= grid.clientWidth) return;
  const [cell, box] = [currentTarget.getBoundingClientRect(), grid.getBoundingClientRect()];
  const labelWidth = grid.querySelector(".of-row")?.clientWidth ?? 0; // the row labels cover the entries
  const [leftGap, rightExcess] = [
    cell.left - box.left - labelWidth - CELL_MARGIN,
    cell.right - box.right + CELL_MARGIN,
  ];
  if (leftGap < 0) grid.scrollLeft += leftGap;
  else if (rightExcess > 0) grid.scrollLeft += Math.min(rightExcess, leftGap);
}

/** Margin (pixels) between an entry and the side of its grid. */
const CELL_MARGIN = 12;

interface FormulaFieldProps {
  readonly label: string;
  readonly value: string;
  readonly isWide?: boolean;
  readonly isMath: boolean;
  /** For a multi-line text: whether Enter begins another line instead of checking. Shift+Enter always does. */
  readonly startsNewLine?: ((text: string) => boolean) | undefined;
  readonly onValue: (text: string) => void;
  readonly onEnter: () => void;
}

/** A field for a formula, as text or as typeset mathematics. */
function FormulaField({ label, value, onValue, onEnter, isMath, isWide = false, startsNewLine }: FormulaFieldProps) {
  if (isMath) return <MathField label={label} value={value} onValue={onValue} onEnter={onEnter} />;
  const attributes = {
    ...LITERAL,
    class: isWide ? "formula-field wide" : "formula-field",
    "aria-label": label,
    value,
    onInput: (event: { readonly currentTarget: { readonly value: string } }) => onValue(event.currentTarget.value),
    onKeyDown: (event: KeyboardEvent) => {
      if (event.key !== "Enter" || event.isComposing) return;
      if (startsNewLine && (event.shiftKey || startsNewLine(value))) return;
      event.preventDefault(); // else Enter would check a second time, by submitting the form
      onEnter();
    },
  };
  if (!startsNewLine) return <input type="text" {...attributes} />;
  return <textarea {...attributes} rows={Math.min(MAX_LINES, value.split("\n").length)} />;
}

/** Maximum number of visible lines. */
const MAX_LINES = 8;

interface FieldsProps extends Pick<AnswerProps, "problem" | "part"> {
  readonly hasSymbols: boolean;
  readonly children: ComponentChildren;
}

/** The fields of an answer, and buttons that insert symbols at the cursor of the last used field. */
function Fields({ problem, part, hasSymbols, children }: FieldsProps) {
  const box = useRef<HTMLDivElement>(null);
  const lastField = useRef<Element | null>(null);
  const rememberField = ({ target }: FocusEvent) => {
    if (target instanceof Element && target.matches(FIELD_SELECTOR)) lastField.current = target;
  };
  const insertSymbol = (text: string, latex: string) => {
    const field = lastField.current?.isConnected ? lastField.current : box.current?.querySelector(FIELD_SELECTOR);
    if (field instanceof HTMLInputElement || field instanceof HTMLTextAreaElement) {
      field.setRangeText(
        text,
        field.selectionStart ?? field.value.length,
        field.selectionEnd ?? field.value.length,
        "end",
      );
      field.dispatchEvent(new Event("input", { bubbles: true }));
      field.focus();
    } else if (field) insertFormula(field, latex);
  };
  // Joints and lengths always; rates, velocities and forces only if the question mentions them.
  const offeredSymbols = Object.entries(problem.symbols).filter(
    ([name, { role, value }]) =>
      value === undefined && (["joint", "length", "angle"].includes(role) || part.names.includes(name)),
  );
  return (
    <div class="answer" ref={box} onFocusIn={rememberField}>
      {children}
      {hasSymbols ? (
        <div class="symbols" role="group" aria-label={say("answer.symbols")}>
          {offeredSymbols.map(([name, { latex }]) => (
            <button
              type="button"
              key={name}
              title={name}
              aria-label={nameButton(name, latex)}
              onClick={() => insertSymbol(name, latex)}
            >
              <Letter latex={latex} />
            </button>
          ))}
          {FUNCTIONS.map(([name, text, latex]) => (
            <button type="button" key={name} onClick={() => insertSymbol(text, latex)}>
              {name}
            </button>
          ))}
        </div>
      ) : null}
    </div>
  );
}

const FIELD_SELECTOR = "input.formula-field, textarea.formula-field, math-field";
const FUNCTIONS = [
  ["sin", "sin(", "\\sin\\left(#?\\right)"],
  ["cos", "cos(", "\\cos\\left(#?\\right)"],
  ["sqrt", "sqrt(", "\\sqrt{#?}"],
  ["pi", "pi", "\\pi"],
] as const;

/** A longer formula is judged, but not typeset. */
const MAX_PREVIEW_LENGTH = 5000;

/** The parsed answer, typeset; below Check, so that the button does not move while it is pressed. */
export function Preview(props: Pick<AnswerProps, "problem" | "part"> & { answer: string }): JSX.Element | null {
  const { answer, problem, part } = props;
  const { type } = part.key;
  const text = type === "configurations" ? answer : readCommasAsPoints(answer);
  const settledText = useDebounced(text, 150);
  const preview = useMemo(() => makePreview(settledText, problem, part), [settledText, problem, part]);
  if (isByLetters(part.key) || part.key.type === "text") return null;
  return (
    <p class="preview" aria-live="polite">
      {preview === null ? null : "latex" in preview ? (
        <>
          <span class="muted">{say("answer.read-as")}</span> <Tex latex={preview.latex} block />
        </>
      ) : (
        <span class="muted">{preview.why}</span>
      )}
    </p>
  );
}

/** Return a typed formula as LaTeX; "" if it can't be parsed, because the field could not show it. */
function writeLatex(text: string, problem: AskedProblem): string {
  const preview = makePreview(readCommasAsPoints(text), problem);
  return preview && "latex" in preview ? preview.latex.replaceAll("{,}", ".") : "";
}

type FormulaPreview = { readonly latex: string } | { readonly why: string };

function makePreview(text: string, problem: AskedProblem, part: AskedPart | null = null): FormulaPreview | null {
  if (!text.trim() || text.length > MAX_PREVIEW_LENGTH) return null;
  const symbolNames = new Set(Object.keys(problem.symbols));
  return catchParseError<FormulaPreview, FormulaPreview>(
    () => ({
      latex: typesetTree(part ? parseAnswer(text, symbolNames, part) : parse(text, symbolNames), problem.symbols),
    }),
    (error) => ({ why: textOf(error.why) }),
  );
}

function Letters(props: AnswerProps) {
  const { problem, part, onAnswer, storedText = "" } = props;
  const { lang } = problem;
  const options = part.options ?? [];
  const storedOptions = [...storedText].map((letter) => LETTERS.indexOf(letter));
  const [chosenOptions, setChosen] = useDraft<readonly (number | null)[]>(
    nameDraft(props, "options"),
    storedOptions.filter((option) => option >= 0 && option < options.length),
  );
  const changeChoice = (newChoice: readonly (number | null)[]) => {
    setChosen(newChoice);
    onAnswer(
      newChoice.every((option) => option !== null) ? newChoice.map((option) => LETTERS[option as number]).join("") : "",
    );
  };
  useEffect(() => changeChoice(chosenOptions), []);
  if (part.key.type === "matching") {
    const itemCount = part.key.items;
    const chosenByItem = Array.from({ length: itemCount }, (_, i) => chosenOptions[i] ?? null);
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
        {chosenByItem.map((option, i) => (
          <label class="match" key={i}>
            {say("answer.match", { index: i + 1 })}
            <select
              value={option ?? ""}
              onChange={(event) => {
                const value = event.currentTarget.value;
                changeChoice(chosenByItem.with(i, value === "" ? null : Number(value)));
              }}
            >
              <option value="">{say("answer.choose")}</option>
              {optionsOf(options.map((_, k) => [k, LETTERS[k]!]))}
            </select>
          </label>
        ))}
      </div>
    );
  }
  const isSingle = part.key.type === "choice";
  return (
    <fieldset class="answer options">
      <legend class="help">
        <span class="visually-hidden">{say("answer.label")}: </span>
        {say(isSingle ? "answer.choose-one" : "answer.choose-all")}
      </legend>
      {options.map((option, i) => (
        <label class="option" key={i}>
          <input
            type={isSingle ? "radio" : "checkbox"}
            name="option"
            checked={chosenOptions.includes(i)}
            onChange={() => {
              const others = chosenOptions.filter((option) => option !== i);
              changeChoice(isSingle ? [i] : others.length === chosenOptions.length ? [...chosenOptions, i] : others);
            }}
          />
          <strong>{LETTERS[i]}</strong> <Html html={option} class="option-text" lang={lang} />
        </label>
      ))}
    </fieldset>
  );
}
