// The page for students' notebooks: a file is dropped or chosen, and the page lists how qdot reads each answer.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { isTrueOrFalse } from "../grade/letters.js";
import { Rich, Tex } from "../practice/math.js";
import { type Message, message, numberSeparator, say, textOf, type TextKey } from "../text/text.js";
import { DropField } from "./drop-field.js";
import { type CheckedNotebook, checkNotebook, type FoundAnswer, parseOrigin, shorten } from "./notebook.js";
import type { Form } from "./reading.js";

/** The notebook that was chosen last; null before the first. */
type Checked = (CheckedNotebook & { readonly fileName: string }) | null;

export function CheckPage({ maxMegabytes }: { maxMegabytes: number }): JSX.Element {
  const [checked, setChecked] = useState<Checked>(null);
  const results = useRef<HTMLHeadingElement>(null);
  const readFiles = async (files: FileList): Promise<void> => {
    const file = files[0];
    if (!file) return;
    const refuse = (key: TextKey): CheckedNotebook => ({
      problems: [],
      notes: [message(key, { name: shorten(file.name, 80), limit: maxMegabytes })],
    });
    const notebook =
      files.length > 1
        ? refuse("check.several-files")
        : file.size > maxMegabytes * 1e6
          ? refuse("check.too-large")
          : await file.text().then(
              (text) => checkNotebook(file.name, text, parseOrigin(window.location.hash)),
              () => refuse("check.no-access"),
            );
    setChecked({ ...notebook, fileName: file.name });
  };
  useEffect(() => results.current?.focus(), [checked]);
  return (
    <>
      <DropField text={say("check.drop")} onFiles={(files) => void readFiles(files)} />
      {checked ? (
        <>
          <h2 ref={results} tabIndex={-1} class="checked-file">
            {shorten(checked.fileName, 80)}
          </h2>
          {checked.problems.length > 0 ? <p role="status">{countReadings(checked)}</p> : null}
          {hasCode(checked) ? <p class="muted">{say("check.code-help")}</p> : null}
          {checked.notes.length > 0 ? (
            <ul class={`verdict ${checked.problems.length > 0 ? "partial" : "missing"}`} role="alert">
              {checked.notes.map((note) => (
                <li key={note.key}>{textOf(note)}</li>
              ))}
            </ul>
          ) : null}
          {checked.problems.map(({ slot, title, answers }) => (
            <section key={slot}>
              <h2 lang={title ? "en" : undefined}>{title || slot}</h2>
              {answers.map((answer) => (
                <Answer key={answer.variable} {...answer} />
              ))}
            </section>
          ))}
        </>
      ) : null}
    </>
  );
}

/** How an answer is read, by its kind: the name of this result, and the look of its frame. */
const RESULTS = {
  formula: ["check.read", "read"],
  letters: ["check.read", "read"],
  words: ["check.words", "read"],
  code: ["check.code", "read"],
  blank: ["check.blank", "partial"],
  partlyBlank: ["check.partly-blank", "partial"],
  refused: ["check.refused", "missing"],
  missing: ["check.missing", "missing"],
} as const satisfies Readonly<Record<string, readonly [TextKey, string]>>;

const findResult = ({ reading }: FoundAnswer): readonly [TextKey, string] =>
  RESULTS[reading.kind === "formula" && reading.isPartlyBlank ? "partlyBlank" : reading.kind];

/** Return how many answers there are of each kind, as text. */
function countReadings({ problems }: CheckedNotebook): string {
  const keys = problems.flatMap(({ answers }) => answers.map((answer) => findResult(answer)[0]));
  return [...new Set(Object.values(RESULTS).map(([key]) => key))]
    .map((key) => [key, keys.filter((other) => other === key).length] as const)
    .filter(([, count]) => count > 0)
    .map(([key, count]) => `${say(key)}: ${count}`)
    .join(" · ");
}

const hasCode = ({ problems }: CheckedNotebook): boolean =>
  problems.some(({ answers }) => answers.some(({ reading }) => reading.kind === "code"));

function Answer(answer: FoundAnswer): JSX.Element {
  const { variable, title, typed, reading, form, notes } = answer;
  const [result, look] = findResult(answer);
  const isRead = look === "read" && reading.kind !== "code";
  return (
    <article class={`verdict checked ${look}`}>
      <h3 lang={title ? "en" : undefined}>{title || variable}</h3>
      <p>
        <strong>{say(result)}</strong>{" "}
        {form && !isRead ? <span class="muted">{say("check.expected", { what: describeForm(form) })}</span> : null}
      </p>
      {typed && reading.kind !== "blank" ? (
        <pre>
          <code>{shorten(typed, 300)}</code>
        </pre>
      ) : null}
      {reading.kind === "formula" ? (
        <p class="preview">
          <span class="muted">{say("answer.read-as")}</span> <Tex latex={reading.latex} block />
        </p>
      ) : null}
      {reading.kind === "letters" ? (
        <p>
          <span class="muted">{say("answer.read-as")}</span>{" "}
          {reading.chosen.map((index) => nameOption(form!, index)).join(", ")}
          {form!.type === "choice" && !isTrueOrFalse(form!.options) ? (
            <>
              {" "}
              <Rich text={form!.options[reading.chosen[0]!] ?? ""} />
            </>
          ) : null}
        </p>
      ) : null}
      {reading.kind === "refused" ? <p>{textOf(reading.why)}</p> : null}
      {notes.map((note) => (
        <p key={note.key}>{textOf(note)}</p>
      ))}
    </article>
  );
}

const LETTERS = "ABCDEFGH";

const nameOption = ({ options }: Form, index: number): string =>
  isTrueOrFalse(options) ? options[index]! : LETTERS[index]!;

/** Return what is expected, such as "a 2 × 3 matrix". */
function describeForm({ type, rows, columns, units, options, items }: Form): Message {
  const values = {
    ...{ rows, columns, count: options.length > 0 ? items.length : rows * columns },
    units: [...new Set(units)].filter(Boolean).join(numberSeparator()),
    letters: options.map((_, i) => nameOption({ options } as Form, i)).join(", "),
  };
  const keyOfNumbers = rows * columns > 1 ? "check.numbers" : "check.a-number";
  const keys: Readonly<Record<Form["type"], TextKey>> = {
    ...({ expression: "check.a-formula", singular: "check.conditions", text: "check.a-text" } as const),
    ...({ choice: "check.a-letter", selection: "check.letters", matching: "check.letter-each" } as const),
    ...({ direction: "check.a-vector", matrix: columns > 1 ? "check.a-matrix" : "check.a-vector" } as const),
    number: values.units ? (rows * columns > 1 ? "check.numbers-in" : "check.a-number-in") : keyOfNumbers,
  };
  return message(keys[type], values);
}
