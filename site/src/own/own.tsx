// The page of the student's own arm: a typed table or a known robot, the moving arm and its numbers. The address is
// always a link to the arm shown.

import type { JSX } from "preact";
import { Button, Choice, type Option, optionsOf } from "../controls.js";
import { memo } from "../pace.js";
import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Arm } from "../arm/panel.js";
import { armOf, namedPose } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import type { NamedPose, Robot } from "../bank.js";
import { CopyButton, saveFile } from "../pages/copied.js";
import { listen } from "../scheduling.js";
import { language, textOf, say } from "../text/text.js";
import { withAnglesIn } from "./angles.js";
import { Editor } from "./editor.js";
import { Figures } from "./figures.js";
import { tomlOf } from "./file.js";
import { type Known, type KnownArms, tableOf } from "./known-arms.js";
import { asFragment, fromFragment } from "./link.js";
import { robotOf } from "./standard.js";
import { type Faults, newRow, noteOn, numbersOf, type Table, ZEROS } from "./table.js";

/** The arm on the page: a table, the known arm that it is, and a pose to begin with (degrees, metres). */
interface OwnState {
  readonly table: Table;
  readonly robot: string | null;
  readonly at: readonly number[] | null;
  /** The error in the link that led to the page. */
  readonly fault: "own.no-table" | "own.no-robot" | null;
}

/** A new table. */
const NEW_TABLE: Table = {
  ...{ name: "", convention: "dh", angles: "degrees", task: null },
  rows: [0, 1].map((row) => ({ ...newRow("R", row), a: "0.5" })),
  ...{ tool: ZEROS, place: ZEROS, turn: ZEROS },
};
const NOTHING_WRONG: Faults = new Map();

export function OwnArm({ known }: { known: KnownArms }): JSX.Element {
  const knownArms = useMemo(() => [...known.plain, ...known.robots], [known]);
  const [state, setOwn] = useState<OwnState>(() => fromAddress(knownArms));
  const [stage, setStage] = useState<Stage | null>(null);
  const numbers = useMemo(() => numbersOf(state.table), [state.table]);
  const faults = numbers instanceof Map ? (numbers as Faults) : NOTHING_WRONG;
  const last = useRef<Robot | null>(null); // while a cell is invalid, the last arm is shown
  const robot = useMemo(() => {
    if (!("rows" in numbers)) return last.current;
    return (last.current = robotOf(state.table, numbers));
  }, [state.table, numbers]);
  const defaultTask = useMemo(
    () => ("rows" in numbers ? robotOf({ ...state.table, task: null }, numbers).task : []),
    [state.table, numbers],
  );
  const pose = useRef<NamedPose | undefined>(undefined);
  const shape = state.table.rows.map(({ kind }) => kind).join("");
  const first = useMemo(() => poseOf(state) ?? poseIfFits(robot, pose.current), [robot]);

  const followLink = (): void => {
    if (!window.location.hash.includes("=") || window.location.hash === writtenFragment.current) return;
    pose.current = undefined;
    setOwn(fromAddress(knownArms));
  };
  useEffect(() => listen(window, "hashchange", followLink), [knownArms]);

  const at = stage?.settledState.pose;
  const fragment = asFragment(
    state.table,
    state.robot,
    at?.length === state.table.rows.length
      ? at.map((value, i) => (state.table.rows[i]!.kind === "R" ? (value * 180) / Math.PI : value))
      : state.at,
  );
  const writtenFragment = useRef("");
  useEffect(() => {
    if (state.fault) return; // an invalid link stays in the address until something is typed
    const { hash } = window.location;
    const isOther = writtenFragment.current !== "" && hash !== writtenFragment.current && hash.includes("=");
    if (isOther) return; // another link was followed; its hashchange event comes next
    writtenFragment.current = fragment;
    if (hash !== fragment) window.history.replaceState(null, "", fragment);
  }, [fragment, state.fault]);

  const changeTable = useCallback(
    (table: Table): void => {
      pose.current ??= first ?? (stage ? namedPose(stage.arm, stage.pose) : undefined);
      setOwn({ table, robot: null, at: null, fault: null });
    },
    [first, stage?.pose],
  );
  const beginWith = useCallback(
    (key: string): void => {
      const start = knownArms.find((arm) => arm.key === key);
      if (key && !start) return;
      pose.current = undefined;
      const table = withAnglesIn(start ? tableOf(start, language().code) : NEW_TABLE, state.table.angles);
      setOwn({ table, robot: start ? key : null, at: null, fault: null });
    },
    [knownArms, state.table.angles],
  );
  const rememberPose = useCallback((next: NamedPose) => void (pose.current = next), []);
  const source = knownArms.find(({ key }) => key === state.robot)?.source;
  const note = "rows" in numbers ? noteOn(numbers) : null;
  return (
    <div class="workspace">
      <article class="task own">
        <h2>{say("own.title")}</h2>
        <p>{say("own.lead")}</p>
        {state.fault ? (
          <p role="alert" class="own-alert">
            {say(state.fault)}
          </p>
        ) : null}
        <div class="own-begin">
          <Begin known={known} chosen={state.robot} onBegin={beginWith} />
          <label>
            {say("own.name")}
            <input
              type="text"
              value={state.table.name}
              maxLength={80}
              onInput={(event) => changeTable({ ...state.table, name: event.currentTarget.value })}
            />
          </label>
        </div>
        {source ? <p class="muted own-source">{say("own.source", { source })}</p> : null}
        <Editor table={state.table} faults={faults} defaultTask={defaultTask} onTable={changeTable} />
        <p role="status" class={faults.size > 0 ? "own-alert" : "muted"}>
          {faults.size > 0 ? say("own.wrong", { count: faults.size }) : note ? textOf(note) : ""}
        </p>
        {stage ? <Figures stage={stage} /> : null}
        <NextSteps table={state.table} link={`${window.location.href.split("#")[0]}${fragment}`} />
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        {robot ? (
          <Arm
            key={shape}
            robot={robot}
            symbols={{}}
            pose={first}
            pane="map"
            inRadians={state.table.angles === "radians"}
            onStage={setStage}
            onPose={rememberPose}
          />
        ) : (
          <p class="muted own-none">{say("own.no-arm")}</p>
        )}
      </section>
    </div>
  );
}

/** Return the last pose if it fits the robot's joints. */
function poseIfFits(robot: Robot | null, pose: NamedPose | undefined): NamedPose | undefined {
  if (!robot || !pose) return undefined;
  return armOf(robot).joints.every(({ name }) => name in pose) ? pose : undefined;
}

/** Return the pose of a link by the names of the joints (rad, m). */
function poseOf({ at, table }: OwnState): NamedPose | undefined {
  if (at?.length !== table.rows.length) return undefined;
  return Object.fromEntries(
    table.rows.map(({ kind }, i) =>
      kind === "R" ? [`theta${i + 1}`, (at[i]! * Math.PI) / 180] : [`d${i + 1}`, at[i]!],
    ),
  );
}

/** Return the arm that the address describes; the first known arm if it describes none. */
function fromAddress(all: readonly Known[]): OwnState {
  const known = (arm: Known): Table => withAnglesIn(tableOf(arm, language().code), NEW_TABLE.angles);
  const first = { table: known(all[0]!), robot: all[0]!.key, at: null };
  const content = fromFragment(window.location.hash);
  if (content === null) return { ...first, fault: null };
  if (content === "unreadable") return { ...first, fault: "own.no-table" };
  if (content.table) return { table: content.table, robot: null, at: content.at, fault: null };
  const robot = all.find(({ key }) => key === content.robot);
  if (!robot) return { ...first, fault: "own.no-robot" };
  return { table: known(robot), robot: robot.key, at: content.at, fault: null };
}

interface BeginProps {
  readonly known: KnownArms;
  readonly chosen: string | null;
  readonly onBegin: (key: string) => void;
}

// `memo`: the menu is not drawn again while the arm moves.
const Begin = memo((props: BeginProps): JSX.Element => {
  const { code } = language();
  const named = (all: readonly Known[]): Option[] => all.map(({ key, name, titles }) => [key, titles?.[code] ?? name]);
  return (
    <Choice label="own.begin" value={props.chosen ?? ""} any="own.typed" onValue={props.onBegin}>
      <optgroup label={say("own.plain")}>{optionsOf(named(props.known.plain))}</optgroup>
      <optgroup label={say("own.robots")}>{optionsOf(named(props.known.robots))}</optgroup>
    </Choice>
  );
});

/** The arm as a link, and as the file from which `qdot solve` derives formulas. */
const NextSteps = memo(({ table, link }: { table: Table; link: string }): JSX.Element => (
  <section class="own-onward">
    <h3>{say("own.onward")}</h3>
    <p>{say("own.link-says")}</p>
    <p class="actions">
      <CopyButton text={link} label={say("own.copy-link")} />
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
