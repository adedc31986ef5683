// Edit a Denavit-Hartenberg table; errors appear below the row of their cell.

import type { JSX } from "preact";
import { ROWS, type TaskRow } from "../bank.js";
import { Button, LITERAL } from "../controls.js";
import { memo } from "../pace.js";
import { useId } from "preact/hooks";

import { rowName } from "../arm/jacobian.js";
import { jointClass, Letters, Words } from "../arm/letters.js";
import { textOf, say } from "../text/text.js";
import { convertAngles } from "./angles.js";
import {
  ANGLES,
  type Cell,
  CONVENTIONS,
  ENTRIES,
  type Entry,
  type Faults,
  MAX_JOINTS,
  makeRow,
  nameVectorCell,
  nameRowCell,
  type Table,
  type TypedRow,
  changeKind,
  removeRow,
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
        <RadioChoice
          legend={say("own.convention")}
          options={CONVENTIONS}
          chosenOption={table.convention}
          nameOption={(convention) => say(`own.convention-${convention}`)}
          onChoose={(convention) => onTable({ ...table, convention })}
        />
        <RadioChoice
          legend={say("own.angles")}
          options={ANGLES}
          chosenOption={table.angles}
          nameOption={(unit) => say(`own.angles-${unit}`)}
          onChoose={(angles) => onTable(convertAngles(table, angles))}
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
          onRemove={() => onTable({ ...table, rows: removeRow(rows, i) })}
        />
      ))}
      <p class="actions">
        {(["R", "P"] as const).map((kind) => (
          <Button
            key={kind}
            className="quiet small"
            text={say(kind === "R" ? "own.add-R" : "own.add-P")}
            disabled={rows.length >= MAX_JOINTS}
            onClick={() => onTable({ ...table, rows: [...rows, makeRow(kind, rows.length)] })}
          />
        ))}
      </p>
      <VectorsAndTask table={table} faults={faults} defaultTask={defaultTask} onTable={onTable} />
    </div>
  );
});

/** A choice among a few options, as radio buttons in a line. */
function RadioChoice<T extends string>(props: {
  legend: string;
  options: readonly T[];
  chosenOption: T;
  nameOption: (option: T) => string;
  onChoose: (option: T) => void;
}): JSX.Element {
  const name = useId();
  return (
    <fieldset class="own-choice">
      <legend>{props.legend}</legend>
      {props.options.map((option) => (
        <label key={option}>
          <input
            type="radio"
            name={name}
            checked={option === props.chosenOption}
            onChange={() => props.onChoose(option)}
          />
          {props.nameOption(option)}
        </label>
      ))}
    </fieldset>
  );
}

const ENTRY_SIGNS: Readonly<Record<Entry, string>> = { theta: "θ", d: "d", a: "a", alpha: "α" };

/** The heading of a column: θᵢ, dᵢ, aᵢ, αᵢ; in a modified table, a and α have the index i−1. */
function Heading({ entry, isModified }: { entry: Entry; isModified: boolean }): JSX.Element {
  const isPreviousIndex = isModified && (entry === "a" || entry === "alpha");
  return (
    <span>
      <i>{ENTRY_SIGNS[entry]}</i>
      <sub>
        <i>i</i>
        {isPreviousIndex ? "−1" : ""}
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
        onChange={(event) => onRow(changeKind(row, event.currentTarget.value === "P" ? "P" : "R", index))}
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
          cell={nameRowCell(index, entry)}
          name={`${ENTRY_SIGNS[entry]}${number}`}
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
        cells={ENTRIES.map((entry): NamedCell => [nameRowCell(index, entry), `${ENTRY_SIGNS[entry]}${number}`])}
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
        aria-describedby={isWrong ? makeFaultId(cell) : undefined}
        value={text}
        onInput={(event) => onText(event.currentTarget.value)}
      />
    </label>
  );
}

const makeFaultId = (cell: Cell): string => `wrong-${cell.replaceAll("/", "-")}`;

type NamedCell = readonly [cell: Cell, name: string];

/** The errors in some cells. */
function FaultList({ faults, cells }: { faults: Faults; cells: readonly NamedCell[] }): JSX.Element | null {
  const wrongCells = cells.filter(([cell]) => faults.has(cell));
  if (wrongCells.length === 0) return null;
  return (
    <ul class="own-wrong">
      {wrongCells.map(([cell, name]) => (
        <li key={cell} id={makeFaultId(cell)}>
          <strong>{name}</strong>: {textOf(faults.get(cell)!)}
        </li>
      ))}
    </ul>
  );
}

const VECTOR_AXES = [
  ["tool", ["x", "y", "z"]],
  ["place", ["x", "y", "z"]],
  ["turn", ["roll", "pitch", "yaw"]],
] as const;

/** The point, the base, and the task rows. */
function VectorsAndTask({ table, faults, defaultTask, onTable }: EditorProps): JSX.Element {
  const isOpen = VECTOR_AXES.some(
    ([place]) => [0, 1, 2].some((axis) => faults.has(nameVectorCell(place, axis))), // else the error is not visible
  );
  return (
    <details class="own-more" open={isOpen || undefined}>
      <summary>{say("own.more")}</summary>
      {VECTOR_AXES.map(([place, axes]) => (
        <fieldset key={place} class="own-three">
          <legend>
            <Words text={say(`own.${place}`)} />
          </legend>
          {axes.map((axis, k) => (
            <Field
              key={axis}
              cell={nameVectorCell(place, k)}
              name={place === "turn" ? say(`own.${axis as "roll" | "pitch" | "yaw"}`) : axis}
              text={table[place][k]!}
              faults={faults}
              onText={(text) => {
                const [x, y, z] = table[place].with(k, text);
                onTable({ ...table, [place]: [x!, y!, z!] });
              }}
            />
          ))}
          <FaultList faults={faults} cells={axes.map((axis, k) => [nameVectorCell(place, k), axis] as const)} />
        </fieldset>
      ))}
      <Task table={table} defaultTask={defaultTask} onTable={onTable} />
    </details>
  );
}

/** The rows of J that the task counts; by default those in which the arm moves. */
function Task({ table, defaultTask, onTable }: Pick<EditorProps, "table" | "defaultTask" | "onTable">): JSX.Element {
  const chosenRows: readonly string[] = table.task ?? defaultTask;
  const toggleRow = (row: TaskRow): void => {
    const newRows = ROWS.filter((name) => (name === row ? !chosenRows.includes(name) : chosenRows.includes(name)));
    if (newRows.length > 0) onTable({ ...table, task: newRows.join() === defaultTask.join() ? null : newRows });
  };
  return (
    <fieldset class="own-task">
      <legend>
        <Words text={say("own.task")} />
      </legend>
      {ROWS.map((row, i) => (
        <label key={row}>
          <input type="checkbox" checked={chosenRows.includes(row)} onChange={() => toggleRow(row)} />
          <Letters name={rowName(i)} />
        </label>
      ))}
    </fieldset>
  );
}
