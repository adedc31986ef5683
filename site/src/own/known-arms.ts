// The known arms with which a table may begin, as exercises/site/robots.py writes them into the bank.

import type { Table } from "./table.js";

export interface KnownArm extends Table {
  /** The arm's name in links. */
  readonly key: string;
  /** Its name in languages other than English, by the language's code. */
  readonly titles?: Readonly<Record<string, string>>;
  /** The publication from which the numbers are taken. */
  readonly source?: string;
}

/** robots.json: arms of the chapter (`plain`), and robots on the market. */
export type KnownArms = {
  readonly format: 1;
  readonly plain: readonly KnownArm[];
  readonly robots: readonly KnownArm[];
};

/** Return the table of a known arm, with its name in a language. */
export function makeTable({ key: _, titles, source: __, ...table }: KnownArm, language: string): Table {
  return { ...table, name: titles?.[language] ?? table.name };
}
