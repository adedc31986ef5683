// The arms that one may begin with, as exercises/site/robots.py writes them into the bank.

import type { Table } from "./table.js";

export interface Known extends Table {
  /** By which a link names it. */
  readonly key: string;
  /** Its name in languages other than English. */
  readonly titles?: Readonly<Record<string, string>>;
  /** Where its numbers are from. */
  readonly source?: string;
}

export type KnownArms = { readonly format: 1; readonly plain: readonly Known[]; readonly robots: readonly Known[] };

/** The table of a known arm alone, under its name in a language. */
export function tableOf({ key: _, titles, source: __, ...table }: Known, language: string): Table {
  return { ...table, name: titles?.[language] ?? table.name };
}
