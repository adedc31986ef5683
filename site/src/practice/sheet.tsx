// A printable sheet: the first questions of a set with figure, table and room for answers; the correct answers follow
// on a page of their own.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import { Button, Choice, optionsOf } from "../controls.js";
import { type Index, isByLetters, type Part, type Problem } from "../bank.js";
import { isAtLeast } from "../grade/levels.js";
import { useLoaded } from "../scheduling.js";
import { loadProblem } from "../load.js";
import { parse } from "../read/reader.js";
import { catchParseError } from "../read/tree.js";
import { typesetTree } from "../read/typeset.js";
import { formatNumber, say } from "../text/text.js";
import { writeWish, listSetItems, type Item, nameItem, type Wish } from "./choice.js";
import { Html, Tex } from "./math.js";
import { removeLetterInstructions } from "./prompt.js";

/** The number of questions on a sheet, and whether the correct answers are printed after them. */
type SheetWish = { readonly count: number; readonly hasKey: boolean };

/** Maximum number of questions on a sheet. */
const MAX_COUNT = 20;

/** Parse the end of an address; null if it asks for no sheet. */
export function parseSheetWish(search: string): SheetWish | null {
  const parameters = new URLSearchParams(search);
  const count = Number(parameters.get("sheet") ?? NaN);
  return Number.isInteger(count) && count >= 1
    ? { count: Math.min(count, MAX_COUNT), hasKey: parameters.has("key") }
    : null;
}

export function writeSheetLink(wish: Wish, { count, hasKey }: SheetWish): string {
  const link = writeWish(wish);
  return `${link}${link ? "&" : "?"}sheet=${count}${hasKey ? "&key=1" : ""}`;
}

/** A question of a sheet. */
type SheetQuestion = { readonly item: Item; readonly part: Part };

/** An arm of a sheet, and the questions about it. */
type SheetArm = { readonly problem: Problem; readonly questions: readonly SheetQuestion[] };

type SheetProps = { index: Index; wish: Wish; initialSheet: SheetWish };

export function Sheet({ index, wish, initialSheet }: SheetProps): JSX.Element {
  const hasSolutions = isAtLeast(index.feedback, "solutions"); // else there are no answers in the bank
  const [sheet, setSheet] = useState({ ...initialSheet, hasKey: initialSheet.hasKey && hasSolutions });
  const listSheetItems = (): readonly Item[] => listSetItems(index, { ...wish, count: sheet.count });
  const { loaded: arms, error } = useLoaded(() => loadArms(listSheetItems()), [sheet.count]);
  const changeSheet = (newSheet: SheetWish) => {
    setSheet(newSheet);
    window.history.replaceState(null, "", writeSheetLink(wish, newSheet));
  };
  return (
    <>
      <form class="settings sheet-settings" onSubmit={(event) => event.preventDefault()}>
        <Choice
          label="sheet.count"
          value={sheet.count}
          onValue={(count) => changeSheet({ ...sheet, count: Number(count) })}
        >
          {optionsOf(Array.from({ length: MAX_COUNT }, (_, i) => [i + 1, String(i + 1)]))}
        </Choice>
        {hasSolutions ? (
          <label class="sheet-check">
            <input
              type="checkbox"
              checked={sheet.hasKey}
              onChange={() => changeSheet({ ...sheet, hasKey: !sheet.hasKey })}
            />
            {say("sheet.with-key")}
          </label>
        ) : null}
        <Button className="button" text={say("sheet.print")} disabled={!arms} onClick={() => window.print()} />
        <a href={writeWish(wish) || window.location.pathname}>{say("sheet.back")}</a>
      </form>
      {error ? <p role="alert">{error}</p> : null}
      {arms ? <Paper arms={arms} set={wish.set} hasKey={sheet.hasKey} /> : null}
      {!arms && !error ? <p role="status">{say("practice.loading")}</p> : null}
    </>
  );
}

/** Load the problems of items, and group the items by arm, in the order of the first item about each arm. */
async function loadArms(items: readonly Item[]): Promise<readonly SheetArm[]> {
  const problems = await Promise.all(items.map(({ family, key, question }) => loadProblem(family, key, question)));
  const arms = new Map<string, { problem: Problem; questions: SheetQuestion[] }>();
  for (const [i, item] of items.entries()) {
    const problem = problems[i] as Problem;
    const arm = arms.get(`${item.family}/${item.key}`) ?? { problem, questions: [] };
    arms.set(`${item.family}/${item.key}`, arm);
    arm.questions.push(...problem.parts.map((part) => ({ item, part })));
  }
  return [...arms.values()];
}

function Paper({ arms, set, hasKey }: { arms: readonly SheetArm[]; set: string; hasKey: boolean }) {
  let lastNumber = 0;
  const numberedArms = arms.map(({ problem, questions }) => ({
    problem,
    questions: questions.map((question) => ({ ...question, number: (lastNumber += 1) })),
  }));
  return (
    <div class="sheet">
      <p class="sheet-head">
        <span>{say("sheet.name")}</span>
        <span>{say("sheet.date")}</span>
        {set ? <span class="sheet-set">{say("sheet.set", { set })}</span> : null}
      </p>
      {numberedArms.map(({ problem, questions }) => (
        <section class="sheet-arm" key={problem.id}>
          <h2 lang={problem.lang ?? "en"}>{problem.title}</h2>
          <figure lang="en" dangerouslySetInnerHTML={{ __html: problem.figure }} />
          <Html html={problem.statement} class="statement" lang={problem.lang} />
          {questions.map(({ item, part, number }) => (
            <section class="sheet-question" key={nameItem(item)}>
              <h3 lang={problem.lang ?? "en"}>
                {number}. {part.title}
              </h3>
              {part.figure ? <figure lang="en" dangerouslySetInnerHTML={{ __html: part.figure }} /> : null}
              <Html html={removeLetterInstructions(part)} class="prompt" lang={problem.lang} />
              <Room part={part} />
            </section>
          ))}
        </section>
      ))}
      {hasKey ? (
        <section class="sheet-key">
          <h2>{say("sheet.key")}</h2>
          <ol>
            {numberedArms.flatMap(({ problem, questions }) =>
              questions.map(({ item, part }) => (
                <li key={nameItem(item)}>
                  <CorrectAnswer text={part.solved?.typed ?? ""} part={part} problem={problem} />
                </li>
              )),
            )}
          </ol>
        </section>
      ) : null}
    </div>
  );
}

/** Room for an answer by hand: blank lines for numbers and letters, empty space for formulas. */
function Room({ part }: { part: Part }) {
  const { key } = part;
  const lines = key.type === "numbers" ? key.units.map((unit) => ["", unit]) : listLetterLines(key);
  if (!lines) return <div class="sheet-room" style={{ "--rows": String((part.shape?.[0] ?? 1) + 2) }} />;
  return (
    <p class="sheet-lines">
      {lines.map(([textBefore, textAfter], i) => (
        <span key={i}>
          {textBefore}
          <span class="sheet-blank" /> {textAfter}
        </span>
      ))}
    </p>
  );
}

/** Return the texts before and after each blank for letters; null for other answers. */
function listLetterLines(key: Part["key"]): string[][] | null {
  if (!isByLetters(key)) return null;
  return key.type === "matching" ? Array.from({ length: key.items }, (_, i) => [`${i + 1}: `, ""]) : [["", ""]];
}

/** A correct answer: rounded numbers, letters without quotes, or a typeset formula. */
function CorrectAnswer({ text, part, problem }: { text: string; part: Part; problem: Problem }) {
  const { key } = part;
  if (key.type === "numbers") {
    const numbers = key.right.map((value, i) => `${formatNumber(Number(value.toPrecision(4)))} ${key.units[i]}`);
    return <span>{numbers.join("; ")}</span>;
  }
  const letters = /^\W*([A-H]+)\W*$/.exec(text)?.[1];
  if (letters) return <span>{letters}</span>;
  const symbolNames = new Set(Object.keys(problem.symbols));
  return catchParseError(
    () => <Tex latex={typesetTree(parse(text, symbolNames), problem.symbols)} block />,
    () => <code>{text}</code>,
  );
}
