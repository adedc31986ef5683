// The page of today's arm: its question, the tries so far, and the score as a text to share; and the way to it.

import type { JSX } from "preact";
import { useMemo, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { Copied } from "../pages/copied.js";
import { say } from "../text/text.js";
import { attempted } from "./choice.js";
import { counted, outcomesInWords, sortingOf } from "./counting.js";
import { Current } from "./current.js";
import { keep, kept } from "./progress.js";
import { keepSkills, keptSkills } from "./skills.js";
import { storage } from "../storage.js";
import { dayOf, type Day, isSolved, itemOf, keepDay, keptDay, marks, onDay, tried } from "./today.js";

export const ADDRESS = "practice.html?today=1";

export const isToday = (search: string): boolean => new URLSearchParams(search).has("today");

export function TodaysArm({ index }: { index: Index }): JSX.Element {
  const [today] = useState(() => dayOf(Date.now())); // who begins before midnight ends what was begun
  const item = useMemo(() => itemOf(index, today), [index, today]);
  const [day, setDay] = useState<Day | null>(() => item && onDay(keptDay(storage), today, item));
  const sorting = useMemo(() => sortingOf(index), [index]);
  const [notes, setNotes] = useState<readonly string[]>([]);
  if (!item || !day) return <p>{say("practice.none")}</p>;
  const note = (right: boolean, helped: boolean): void => {
    const next = tried(day, right, helped);
    setDay(next);
    keepDay(storage, next);
    const now = Date.now();
    keep(storage, attempted(kept(storage), item, right, now));
    if (isSolved(day)) return; // it has counted
    const again = day.tries.length > 0;
    const found = counted(keptSkills(storage), item, { right, helped, again, now }, sorting);
    keepSkills(storage, found.skills);
    setNotes(outcomesInWords(found.outcomes));
  };
  return (
    <div class="workspace">
      <div class="choosing today">
        <p class="kicker">
          <a href="practice.html">{say("page.practise")}</a>
          <span class="muted"> · {today}</span>
        </p>
        <p class="lesson-title">
          <strong>{say("today.title")}</strong>
        </p>
        <p role="status">{told(day)}</p>
        {isSolved(day) ? (
          <p class="actions">
            <Copied text={score(index, day)} label={say("today.share")} />
          </p>
        ) : (
          <p class="muted">{say("today.says")}</p>
        )}
      </div>
      <Current
        item={item}
        level={index.feedback}
        arrived={false}
        notes={notes}
        onVerdict={note}
        onNext={() => window.location.assign("practice.html")}
      />
    </div>
  );
}

/** How it went so far, in words. */
function told(day: Day): string {
  const count = day.tries.length;
  if (count === 0) return say("today.not-tried");
  if (!isSolved(day)) return say("today.tried", { marks: marks(day), count });
  return say(day.helped ? "today.solved-helped" : "today.solved", { marks: marks(day), count, row: day.row });
}

/** The score as a text: what was asked, tries as signs, and where it is. */
function score(index: Index, day: Day): string {
  const [family, , question] = day.item.split("/");
  const title = (all: readonly { name: string; title: string }[], name: string | undefined): string =>
    all.find((each) => each.name === name)?.title ?? "";
  return [
    say("today.score", { day: day.day }),
    `${title(index.families, family)}: ${title(index.questions, question)}`,
    `${marks(day)}${day.helped ? ` (${say("today.helped")})` : ""}`,
    new URL(ADDRESS, window.location.href).href,
  ].join("\n");
}

/** The way to today's arm, and how it stands. */
export function TodayDoor({ index }: { index: Index }): JSX.Element | null {
  const day = useMemo(() => {
    const today = dayOf(Date.now());
    const item = itemOf(index, today);
    return item && onDay(keptDay(storage), today, item);
  }, [index]);
  if (!day) return null;
  return (
    <p class="today-door">
      <a href={ADDRESS}>{say("today.title")}</a>{" "}
      <span class="muted">{day.tries.length > 0 ? marks(day) : say("today.new")}</span>
    </p>
  );
}
