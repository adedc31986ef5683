// The page of the student's own arm: a typed table or a known robot, the moving arm and its numbers. The address is
// always a link to what is shown.

import type { JSX } from "preact";
import { Button } from "../button.js";
import { memo } from "../memo.js";
import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Arm } from "../arm/panel.js";
import { armOf, namedPose } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import type { NamedPose, Robot } from "../bank.js";
import { Copied, saveFile } from "../pages/copied.js";
import { language, said, say } from "../text/text.js";
import { inAngles } from "./angles.js";
import { Editor } from "./editor.js";
import { Figures } from "./figures.js";
import { tomlOf } from "./file.js";
import { type Known, type KnownArms, tableOf } from "./known.js";
import { asFragment, fromFragment } from "./link.js";
import { robotOf } from "./standard.js";
import { type Faults, newRow, noteOn, numbersOf, type Table, ZEROS } from "./table.js";

/** What is told: a table, the known arm that it is, and a pose to begin with (degrees, metres). */
interface Own {
  readonly table: Table;
  readonly robot: string | null;
  readonly at: readonly number[] | null;
  /** What was wrong with the link by which one came. */
  readonly fault: "own.no-table" | "own.no-robot" | null;
}

/** What a table of one's own begins with. */
const PLAINEST: Table = {
  ...{ name: "", convention: "dh", angles: "degrees", task: null },
  rows: [0, 1].map((row) => ({ ...newRow("R", row), a: "0.5" })),
  ...{ tool: ZEROS, place: ZEROS, turn: ZEROS },
};
const NOTHING_WRONG: Faults = new Map();

export function OwnArm({ known }: { known: KnownArms }): JSX.Element {
  const all = useMemo(() => [...known.plain, ...known.robots], [known]);
  const [own, setOwn] = useState<Own>(() => fromAddress(all));
  const [stage, setStage] = useState<Stage | null>(null);
  const numbers = useMemo(() => numbersOf(own.table), [own.table]);
  const faults = numbers instanceof Map ? (numbers as Faults) : NOTHING_WRONG;
  const last = useRef<Robot | null>(null); // while a cell is wrong, the arm stays as it was
  const robot = useMemo(() => {
    if (!("rows" in numbers)) return last.current;
    return (last.current = robotOf(own.table, numbers));
  }, [own.table, numbers]);
  const usual = useMemo(
    () => ("rows" in numbers ? robotOf({ ...own.table, task: null }, numbers).task : []),
    [own.table, numbers],
  );
  const pose = useRef<NamedPose | undefined>(undefined);
  const shape = own.table.rows.map(({ kind }) => kind).join("");
  const first = useMemo(() => poseOf(own) ?? kept(robot, pose.current), [robot]);

  useEffect(() => {
    const go = (): void => {
      if (!window.location.hash.includes("=") || window.location.hash === written.current) return;
      pose.current = undefined;
      setOwn(fromAddress(all));
    };
    window.addEventListener("hashchange", go);
    return () => window.removeEventListener("hashchange", go);
  }, [all]);

  const at = stage?.rested.pose;
  const fragment = asFragment(
    own.table,
    own.robot,
    at?.length === own.table.rows.length
      ? at.map((value, i) => (own.table.rows[i]!.kind === "R" ? (value * 180) / Math.PI : value))
      : own.at,
  );
  const written = useRef("");
  useEffect(() => {
    if (own.fault) return; // until something is typed, the link that was wrong stays to be looked at
    const { hash } = window.location;
    const isOther = written.current !== "" && hash !== written.current && hash.includes("=");
    if (isOther) return; // another link was followed, of which the page is told in a moment
    written.current = fragment;
    if (window.location.hash !== fragment) window.history.replaceState(null, "", fragment);
  }, [fragment, own.fault]);

  const typed = useCallback(
    (table: Table): void => {
      pose.current ??= first ?? (stage ? namedPose(stage.arm, stage.pose) : undefined); // until it is moved
      setOwn({ table, robot: null, at: null, fault: null });
    },
    [first, stage?.pose],
  );
  const begin = useCallback(
    (key: string): void => {
      const found = all.find((each) => each.key === key);
      if (key && !found) return;
      pose.current = undefined;
      const begun = found ? tableOf(found, language().code) : PLAINEST;
      const table = inAngles(begun, own.table.angles); // as was chosen
      setOwn({ table, robot: found ? key : null, at: null, fault: null });
    },
    [all, own.table.angles],
  );
  const posed = useCallback((now: NamedPose) => void (pose.current = now), []);
  const source = all.find(({ key }) => key === own.robot)?.source;
  const note = "rows" in numbers ? noteOn(numbers) : null;
  return (
    <div class="workspace">
      <article class="task own">
        <h2>{say("own.title")}</h2>
        <p>{say("own.lead")}</p>
        {own.fault ? (
          <p role="alert" class="own-alert">
            {say(own.fault)}
          </p>
        ) : null}
        <div class="own-begin">
          <Begin known={known} chosen={own.robot} onBegin={begin} />
          <label>
            {say("own.name")}
            <input
              type="text"
              value={own.table.name}
              maxLength={80}
              onInput={(event) => typed({ ...own.table, name: event.currentTarget.value })}
            />
          </label>
        </div>
        {source ? <p class="muted own-source">{say("own.source", { source })}</p> : null}
        <Editor table={own.table} faults={faults} usual={usual} onTable={typed} />
        <p role="status" class={faults.size > 0 ? "own-alert" : "muted"}>
          {faults.size > 0 ? say("own.wrong", { count: faults.size }) : note ? said(note) : ""}
        </p>
        {stage ? <Figures stage={stage} /> : null}
        <Onward table={own.table} link={`${window.location.href.split("#")[0]}${fragment}`} />
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        {robot ? (
          <Arm
            key={shape}
            robot={robot}
            symbols={{}}
            pose={first}
            pane="map"
            radians={own.table.angles === "radians"}
            onStage={setStage}
            onPose={posed}
          />
        ) : (
          <p class="muted own-none">{say("own.no-arm")}</p>
        )}
      </section>
    </div>
  );
}

/** Where the arm was, as far as it has the same joints. */
function kept(robot: Robot | null, pose: NamedPose | undefined): NamedPose | undefined {
  if (!robot || !pose) return undefined;
  return armOf(robot).joints.every(({ name }) => name in pose) ? pose : undefined;
}

/** The pose of a link by the names of the joints (rad, m). */
function poseOf({ at, table }: Own): NamedPose | undefined {
  if (at?.length !== table.rows.length) return undefined;
  return Object.fromEntries(
    table.rows.map(({ kind }, i) =>
      kind === "R" ? [`theta${i + 1}`, (at[i]! * Math.PI) / 180] : [`d${i + 1}`, at[i]!],
    ),
  );
}

/** What the address tells; the first known arm where it tells nothing. */
function fromAddress(all: readonly Known[]): Own {
  const known = (arm: Known): Table => inAngles(tableOf(arm, language().code), PLAINEST.angles);
  const first = { table: known(all[0]!), robot: all[0]!.key, at: null };
  const told = fromFragment(window.location.hash);
  if (told === null) return { ...first, fault: null };
  if (told === "unreadable") return { ...first, fault: "own.no-table" };
  if (told.table) return { table: told.table, robot: null, at: told.at, fault: null };
  const robot = all.find(({ key }) => key === told.robot);
  if (!robot) return { ...first, fault: "own.no-robot" };
  return { table: known(robot), robot: robot.key, at: told.at, fault: null };
}

interface BeginProps {
  readonly known: KnownArms;
  readonly chosen: string | null;
  readonly onBegin: (key: string) => void;
}

// What is typed stays as it is while the arm moves: `memo` leaves it alone.
const Begin = memo((props: BeginProps): JSX.Element => {
  const { code } = language();
  const options = (all: readonly Known[]): JSX.Element[] =>
    all.map(({ key, name, titles }) => (
      <option key={key} value={key}>
        {titles?.[code] ?? name}
      </option>
    ));
  return (
    <label>
      {say("own.begin")}
      <select value={props.chosen ?? ""} onChange={(event) => props.onBegin(event.currentTarget.value)}>
        <option value="">{say("own.typed")}</option>
        <optgroup label={say("own.plain")}>{options(props.known.plain)}</optgroup>
        <optgroup label={say("own.robots")}>{options(props.known.robots)}</optgroup>
      </select>
    </label>
  );
});

/** The arm as a link, and as the file from which `qdot solve` derives formulas. */
const Onward = memo(({ table, link }: { table: Table; link: string }): JSX.Element => (
  <section class="own-onward">
    <h3>{say("own.onward")}</h3>
    <p>{say("own.link-says")}</p>
    <p class="actions">
      <Copied text={link} label={say("own.copy-link")} />
    </p>
    <p>{say("own.solve-says")}</p>
    <pre>
      <code>qdot solve arm.toml</code>
    </pre>
    <p class="actions">
      <Button
        style="quiet small"
        text={say("own.save")}
        onClick={() => saveFile("arm.toml", "application/toml", tomlOf(table))}
      />
    </p>
  </section>
));
