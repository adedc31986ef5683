// Today's arm: the same for all, another one each day, of all kinds in the long run, and stable where the bank grows.
import { describe, expect, test } from "vitest";

import type { Index } from "../src/bank.js";
import { nameOf } from "../src/practice/choice.js";
import { dayOf, type Day, isSolved, itemOf, keepDay, keptDay, marks, onDay, tried } from "../src/practice/today.js";

function indexOf(families: number, problems: number): Index {
  return {
    format: 1,
    feedback: "solutions",
    questions: [],
    families: Array.from({ length: families }, (_, f) => ({
      name: `family-${f}`,
      title: "",
      source: "",
      problems: Array.from({ length: problems }, (_, p) => ({
        key: String(p),
        title: "",
        difficulty: (f + p) % 5,
        variation: "full",
        questions: ["jacobian", "determinant", "position"],
      })),
    })),
  };
}

const days = Array.from({ length: 400 }, (_, i) => dayOf(Date.UTC(2026, 10, 25) + i * 24 * 3600 * 1000));
const named = (index: Index, day: string): string => nameOf(itemOf(index, day)!);

describe("the question of a day", () => {
  const index = indexOf(12, 5);

  test("is that of the date in UTC, whatever the hour", () => {
    expect(dayOf(Date.parse("2026-11-25T23:59:59+00:00"))).toBe("2026-11-25");
    expect(dayOf(Date.parse("2026-11-25T23:59:59-01:00"))).toBe("2026-11-26");
    expect(named(index, days[0]!)).toBe(named(indexOf(12, 5), days[0]!));
    expect(named(index, "2026-11-25")).toBe("family-7/3/position"); // what is there was told to many
  });

  test("is of all arms and questions in the long run, and mostly another than the day before", () => {
    const all = days.map((day) => itemOf(index, day)!);
    expect(new Set(all.map(({ family }) => family)).size).toBe(12);
    expect(new Set(all.map(({ question }) => question)).size).toBe(3);
    expect(all.filter((item, i) => i > 0 && nameOf(item) === nameOf(all[i - 1]!)).length).toBeLessThan(8);
  });

  test("is never of the hardest arms, but where there are no others", () => {
    const hard = (name: string): boolean => {
      const [family, key] = name.split("/");
      return (Number(family!.split("-")[1]) + Number(key)) % 5 > 3;
    };
    expect(days.filter((day) => hard(named(index, day)))).toEqual([]);
    const only = {
      ...index,
      families: index.families.map((each) => ({ ...each, problems: each.problems.slice(0, 1) })),
    };
    expect(itemOf({ ...only, families: [only.families[4]!] }, days[0]!)).not.toBeNull();
    expect(itemOf({ ...index, families: [] }, days[0]!)).toBeNull();
  });

  test("stays on most days where the bank grows", () => {
    const more = indexOf(13, 5);
    const other = days.filter((day) => named(index, day) !== named(more, day));
    expect(other.length).toBeLessThan(60); // a thirteenth of 400, and some luck
    other.forEach((day) => expect(named(more, day)).toMatch(/^family-12\//));
  });
});

describe("the score of a day", () => {
  const item = { family: "f", key: "1", question: "jacobian" };
  const start = onDay(null, "2026-11-25", item);

  test("counts tries until it is right, and days in a row", () => {
    const first = tried(tried(start, false, false), true, true);
    expect([marks(first), isSolved(first), first.helped, first.row]).toEqual(["✗ ✓", true, true, 1]);
    expect(tried(first, false, false)).toBe(first);
    const second = tried(onDay(first, "2026-11-26", item), true, false);
    expect([second.row, second.helped]).toEqual([2, false]);
    expect(tried(onDay(second, "2026-11-29", item), true, false).row).toBe(1);
    expect(onDay(first, "2026-11-25", { ...item, key: "2" }).tries).toEqual([]);
  });

  test("is kept, and what is no score is none", () => {
    const kept = new Map<string, string>();
    const storage = {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, text: string) => void kept.set(key, text),
    } as unknown as Storage;
    expect(keptDay(storage)).toBeNull();
    const day: Day = tried(start, false, false);
    keepDay(storage, day);
    expect(keptDay(storage)).toEqual(day);
    for (const wrong of ["{", "[]", "null", '{"day":"x"}', JSON.stringify({ ...day, tries: [1] })]) {
      kept.set("qdot-today", wrong);
      expect(keptDay(storage)).toBeNull();
    }
    expect(keptDay(null)).toBeNull();
  });
});
