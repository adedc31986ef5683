// Edit a Denavit-Hartenberg table; errors appear below the row of their cell.

import type { JSX } from "preact";
import { Button, LITERAL } from "../controls.js";
import { memo } from "../pace.js";
import { useId } from "preact/hooks";

import { rowName } from "../arm/jacobian.js";
import { ROWS } from "../arm/model.js";
import { jointClass, Letters } from "../arm/letters.js";
import { textOf, say } from "../text/text.js";
import { withAnglesIn } from "./angles.js";
import {
  ANGLES,
  type Cell,
  CONVENTIONS,
  ENTRIES,
  type Entry,
  type Faults,
  MAX_JOINTS,
  newRow,
  placeCell,
  rowCell,
  type Table,
  type TypedRow,
  withKind,
  withoutRow,
} from "./table.js";

interface EditorProps {
  readonly table: Table;
  readonly faults: Faults;
  /** The task rows if the table chooses none. */
  readonly defaultTask: readonly string[];
  readonly onTable: (table: Table) => void;
}

export const Editor = memo(({ table, faults, defaultTask, onTable }: EditorProps): JSX.Element => {
  const { rows } = table;
  const setRow = (index: number, row: TypedRow): void => onTable({ ...table, rows: rows.with(index, row) });
  return (
    <div class="own-table">
      <div class="own-how">
        <Choice
          legend={say("own.convention")}
          all={CONVENTIONS}
          chosen={table.convention}
          text={(convention) => say(`own.convention-${convention}`)}
          onChoose={(convention) => onTable({ ...table, convention })}
        />
        <Choice
          legend={say("own.angles")}
          all={ANGLES}
          chosen={table.angles}
          text={(unit) => say(`own.angles-${unit}`)}
          onChoose={(angles) => onTable(withAnglesIn(table, angles))}
        />
      </div>
      <p class="own-head" aria-hidden="true">
        <span />
        <span />
        {ENTRIES.map((entry) => (
          <Heading key={entry} entry={entry} isModified={table.convention === "modified-dh"} />
        ))}
        <span />
      </p>
      {rows.map((row, i) => (
        <RowFields
          key={i}
          index={i}
          row={row}
          faults={faults}
          isOnly={rows.length === 1}
          onRow={(next) => setRow(i, next)}
          onRemove={() => onTable({ ...table, rows: withoutRow(rows, i) })}
        />
      ))}
      <p class="actions">
        {(["R", "P"] as const).map((kind) => (
          <Button
            key={kind}
            style="quiet small"
            text={say(kind === "R" ? "own.add-R" : "own.add-P")}
            disabled={rows.length >= MAX_JOINTS}
            onClick={() => onTable({ ...table, rows: [...rows, newRow(kind, rows.length)] })}
          />
        ))}
      </p>
      <PlacesAndTask table={table} faults={faults} defaultTask={defaultTask} onTable={onTable} />
    </div>
  );
});

/** A choice among a few options, as radio buttons in a line. */
function Choice<T extends string>(props: {
  legend: string;
  all: readonly T[];
  chosen: T;
  text: (option: T) => string;
  onChoose: (option: T) => void;
}): JSX.Element {
  const name = useId();
  return (
    <fieldset class="own-choice">
      <legend>{props.legend}</legend>
      {props.all.map((option) => (
        <label key={option}>
          <input type="radio" name={name} checked={option === props.chosen} onChange={() => props.onChoose(option)} />
          {props.text(option)}
        </label>
      ))}
    </fieldset>
  );
}

const SIGNS: Readonly<Record<Entry, string>> = { theta: "θ", d: "d", a: "a", alpha: "α" };

/** The heading of a column: θᵢ, dᵢ, aᵢ, αᵢ; in a modified table, a and α have the index i−1. */
function Heading({ entry, isModified }: { entry: Entry; isModified: boolean }): JSX.Element {
  const earlier = isModified && (entry === "a" || entry === "alpha");
  return (
    <span>
      <i>{SIGNS[entry]}</i>
      <sub>
        <i>i</i>
        {earlier ? "−1" : ""}
      </sub>
    </span>
  );
}

interface RowProps {
  readonly index: number;
  readonly row: TypedRow;
  readonly faults: Faults;
  readonly isOnly: boolean;
  readonly onRow: (row: TypedRow) => void;
  readonly onRemove: () => void;
}

function RowFields({ index, row, faults, isOnly, onRow, onRemove }: RowProps): JSX.Element {
  const number = index + 1;
  return (
    <fieldset class={`own-row ${jointClass(index)}`}>
      <legend class="visually-hidden">{say("own.joint", { number })}</legend>
      <span class="own-number" aria-hidden="true">
        {number}
      </span>
      <select
        aria-label={say("own.kind", { number })}
        value={row.kind}
        onChange={(event) => onRow(withKind(row, event.currentTarget.value === "P" ? "P" : "R", index))}
      >
        <option value="R" title={say("own.kind-R")}>
          R
        </option>
        <option value="P" title={say("own.kind-P")}>
          P
        </option>
      </select>
      {ENTRIES.map((entry) => (
        <Field
          key={entry}
          cell={rowCell(index, entry)}
          name={`${SIGNS[entry]}${number}`}
          text={row[entry]}
          faults={faults}
          onText={(text) => onRow({ ...row, [entry]: text })}
        />
      ))}
      <button
        type="button"
        class="own-remove"
        disabled={isOnly}
        aria-label={say("own.remove", { number })}
        title={say("own.remove", { number })}
        onClick={onRemove}
      >
        ×
      </button>
      <FaultList
        faults={faults}
        cells={ENTRIES.map((entry): Named => [rowCell(index, entry), `${SIGNS[entry]}${number}`])}
      />
    </fieldset>
  );
}

interface FieldProps {
  readonly cell: Cell;
  readonly name: string;
  readonly text: string;
  readonly faults: Faults;
  readonly onText: (text: string) => void;
}

function Field({ cell, name, text, faults, onText }: FieldProps): JSX.Element {
  const isWrong = faults.has(cell);
  return (
    <label class="own-field">
      <span class="own-name" aria-hidden="true">
        {name}
      </span>
      <input
        type="text"
        {...LITERAL}
        inputMode="text"
        placeholder="0"
        maxLength={100}
        aria-label={name}
        aria-invalid={isWrong}
        aria-describedby={isWrong ? faultId(cell) : undefined}
        value={text}
        onInput={(event) => onText(event.currentTarget.value)}
      />
    </label>
  );
}

const faultId = (cell: Cell): string => `wrong-${cell.replaceAll("/", "-")}`;

type Named = readonly [cell: Cell, name: string];

/** The errors in some cells. */
function FaultList({ faults, cells }: { faults: Faults; cells: readonly Named[] }): JSX.Element | null {
  const wrong = cells.filter(([cell]) => faults.has(cell));
  if (wrong.length === 0) return null;
  return (
    <ul class="own-wrong">
      {wrong.map(([cell, name]) => (
        <li key={cell} id={faultId(cell)}>
          <strong>{name}</strong>: {textOf(faults.get(cell)!)}
        </li>
      ))}
    </ul>
  );
}

const PLACES = [
  ["tool", ["x", "y", "z"]],
  ["place", ["x", "y", "z"]],
  ["turn", ["roll", "pitch", "yaw"]],
] as const;

/** The point, the base, and the task rows. */
function PlacesAndTask({ table, faults, defaultTask, onTable }: EditorProps): JSX.Element {
  const isOpen = PLACES.some(
    ([place]) => [0, 1, 2].some((axis) => faults.has(placeCell(place, axis))), // else the error is not visible
  );
  return (
    <details class="own-more" open={isOpen || undefined}>
      <summary>{say("own.more")}</summary>
      {PLACES.map(([place, axes]) => (
        <fieldset key={place} class="own-three">
          <legend>{say(`own.${place}`)}</legend>
          {axes.map((axis, k) => (
            <Field
              key={axis}
              cell={placeCell(place, k)}
              name={place === "turn" ? say(`own.${axis as "roll" | "pitch" | "yaw"}`) : axis}
              text={table[place][k]!}
              faults={faults}
              onText={(text) => {
                const [x, y, z] = table[place].with(k, text);
                onTable({ ...table, [place]: [x!, y!, z!] });
              }}
            />
          ))}
          <FaultList faults={faults} cells={axes.map((axis, k) => [placeCell(place, k), axis] as const)} />
        </fieldset>
      ))}
      <Task table={table} defaultTask={defaultTask} onTable={onTable} />
    </details>
  );
}

/** The rows of J that the task counts; by default those in which the arm moves. */
function Task({ table, defaultTask, onTable }: Pick<EditorProps, "table" | "defaultTask" | "onTable">): JSX.Element {
  const chosen: readonly string[] = table.task ?? defaultTask;
  const toggled = (row: (typeof ROWS)[number]): void => {
    const next = ROWS.filter((name) => (name === row ? !chosen.includes(name) : chosen.includes(name)));
    if (next.length > 0) onTable({ ...table, task: next.join() === defaultTask.join() ? null : next });
  };
  return (
    <fieldset class="own-task">
      <legend>{say("own.task")}</legend>
      {ROWS.map((row, i) => (
        <label key={row}>
          <input type="checkbox" checked={chosen.includes(row)} onChange={() => toggled(row)} />
          <Letters name={rowName(i)} />
        </label>
      ))}
    </fieldset>
  );
}
