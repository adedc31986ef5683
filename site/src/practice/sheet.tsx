// A printable sheet: the first problems of a set with figure, table and room for answers, and a key on its own page.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import { Button, Choice, optionsOf } from "../controls.js";
import type { Index, Part, Problem } from "../bank.js";
import { atLeast } from "../grade/levels.js";
import { useLoaded } from "../scheduling.js";
import { loadProblem, loadSolutions } from "../load.js";
import { parse } from "../read/reader.js";
import { catchParseError } from "../read/tree.js";
import { typesetTree } from "../read/typeset.js";
import { inDigits, say } from "../text/text.js";
import { wishToLink, itemsOfSet, type Item, nameOf, type Wish } from "./choice.js";
import { Html, Tex } from "./math.js";
import { promptOnPaper } from "./prompt.js";

/** The number of questions on a sheet, and whether a key is printed after them. */
export type SheetWish = { readonly count: number; readonly key: boolean };

const MAX_COPIES = 20;

/** Return the sheet that an address asks for; null if it asks for none. */
export function sheetFrom(search: string): SheetWish | null {
  const parameters = new URLSearchParams(search);
  const count = Number(parameters.get("sheet") ?? NaN);
  return Number.isInteger(count) && count >= 1
    ? { count: Math.min(count, MAX_COPIES), key: parameters.has("key") }
    : null;
}

export function sheetLink(wish: Wish, { count, key }: SheetWish): string {
  const link = wishToLink(wish);
  return `${link}${link ? "&" : "?"}sheet=${count}${key ? "&key=1" : ""}`;
}

/** A question of a sheet, and the correct answer as it is typed. */
type SheetQuestion = { readonly item: Item; readonly part: Part; readonly typed: string };

/** An arm of a sheet, and the questions about it. */
type SheetArm = { readonly problem: Problem; readonly asked: readonly SheetQuestion[] };

export function Sheet({ index, wish, first }: { index: Index; wish: Wish; first: SheetWish }): JSX.Element {
  const hasSolutions = atLeast(index.feedback, "solutions"); // else there are no answers in the bank
  const [sheet, setSheet] = useState({ ...first, key: first.key && hasSolutions });
  const asked = (): readonly Item[] => itemsOfSet(index, { ...wish, count: sheet.count });
  const { loaded: groups, failed } = useLoaded(() => loadGroups(asked(), hasSolutions), [sheet.count]);
  const change = (wanted: SheetWish) => {
    setSheet(wanted);
    window.history.replaceState(null, "", sheetLink(wish, wanted));
  };
  return (
    <>
      <form class="settings sheet-settings" onSubmit={(event) => event.preventDefault()}>
        <Choice label="sheet.count" value={sheet.count} onValue={(count) => change({ ...sheet, count: Number(count) })}>
          {optionsOf(Array.from({ length: MAX_COPIES }, (_, i) => [i + 1, String(i + 1)]))}
        </Choice>
        {hasSolutions ? (
          <label class="sheet-check">
            <input type="checkbox" checked={sheet.key} onChange={() => change({ ...sheet, key: !sheet.key })} />
            {say("sheet.with-key")}
          </label>
        ) : null}
        <Button style="button" text={say("sheet.print")} disabled={!groups} onClick={() => window.print()} />
        <a href={wishToLink(wish) || window.location.pathname}>{say("sheet.back")}</a>
      </form>
      {failed ? <p role="alert">{say("practice.failed", { why: failed })}</p> : null}
      {groups ? <Paper groups={groups} set={wish.set} withKey={sheet.key} /> : null}
      {!groups && !failed ? <p role="status">{say("practice.loading")}</p> : null}
    </>
  );
}

/** Load the problems of questions, and group the questions by arm in their order. */
async function loadGroups(items: readonly Item[], hasSolutions: boolean): Promise<readonly SheetArm[]> {
  const arms = new Map<string, Item[]>();
  for (const item of items) {
    const arm = `${item.family}/${item.key}`;
    arms.set(arm, [...(arms.get(arm) ?? []), item]);
  }
  return Promise.all(
    [...arms.values()].map(async (asked) => {
      const { family, key } = asked[0] as Item;
      const [problem, parts] = await Promise.all([
        loadProblem(family, key),
        hasSolutions ? loadSolutions(family, key).then((solutions) => solutions.parts) : [],
      ]);
      return {
        problem,
        asked: asked.flatMap((item) => {
          const part = problem.parts.find(({ kind }) => kind === item.question);
          return part ? [{ item, part, typed: parts.find(({ name }) => name === part.name)?.typed ?? "" }] : [];
        }),
      };
    }),
  );
}

function Paper({ groups, set, withKey }: { groups: readonly SheetArm[]; set: string; withKey: boolean }) {
  let number = 0;
  const numbered = groups.map(({ problem, asked }) => ({
    problem,
    asked: asked.map((question) => ({ ...question, number: (number += 1) })),
  }));
  return (
    <div class="sheet">
      <p class="sheet-head">
        <span>{say("sheet.name")}</span>
        <span>{say("sheet.date")}</span>
        {set ? <span class="sheet-set">{say("sheet.set", { set })}</span> : null}
      </p>
      {numbered.map(({ problem, asked }) => (
        <section class="sheet-arm" key={problem.id}>
          <h2 lang={problem.lang ?? "en"}>{problem.title}</h2>
          <figure lang="en" dangerouslySetInnerHTML={{ __html: problem.figure }} />
          <Html html={problem.statement} class="statement" lang={problem.lang} />
          {asked.map(({ item, part, number }) => (
            <section class="sheet-question" key={nameOf(item)}>
              <h3 lang={problem.lang ?? "en"}>
                {number}. {part.title}
              </h3>
              {part.figure ? <figure lang="en" dangerouslySetInnerHTML={{ __html: part.figure }} /> : null}
              <Html html={promptOnPaper(part)} class="prompt" lang={problem.lang} />
              <Room part={part} />
            </section>
          ))}
        </section>
      ))}
      {withKey ? (
        <section class="sheet-key">
          <h2>{say("sheet.key")}</h2>
          <ol>
            {numbered.flatMap(({ problem, asked }) =>
              asked.map(({ item, part, typed }) => (
                <li key={nameOf(item)}>
                  <CorrectAnswer text={typed} part={part} problem={problem} />
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
  const lines = key.type === "numbers" ? key.units.map((unit) => ["", unit]) : linesForLetters(key);
  if (!lines) return <div class="sheet-room" style={{ "--rows": String((part.shape?.[0] ?? 1) + 2) }} />;
  return (
    <p class="sheet-lines">
      {lines.map(([before, after], i) => (
        <span key={i}>
          {before}
          <span class="sheet-blank" /> {after}
        </span>
      ))}
    </p>
  );
}

/** Return the texts before and after each blank for letters; null for other answers. */
function linesForLetters(key: Part["key"]): string[][] | null {
  if (!("option_mistakes" in key)) return null;
  return key.type === "matching" ? Array.from({ length: key.items }, (_, i) => [`${i + 1}: `, ""]) : [["", ""]];
}

/** A correct answer: rounded numbers, letters without quotes, or a typeset formula. */
function CorrectAnswer({ text, part, problem }: { text: string; part: Part; problem: Problem }) {
  const { key } = part;
  if (key.type === "numbers") {
    const numbers = key.right.map((value, i) => `${inDigits(Number(value.toPrecision(4)))} ${key.units[i]}`);
    return <span>{numbers.join("; ")}</span>;
  }
  const letters = /^\W*([A-H]+)\W*$/.exec(text)?.[1];
  if (letters) return <span>{letters}</span>;
  const known = new Set(Object.keys(problem.symbols));
  return catchParseError(
    () => <Tex latex={typesetTree(parse(text, known), problem.symbols)} block />,
    () => <code>{text}</code>,
  );
}
