// The page of the student's own arm: a typed table or a known robot, the moving arm and its numbers. The address is
// always a link to the arm shown.

import type { JSX } from "preact";
import { Words } from "../arm/letters.js";
import { Button, Choice, type Option, optionsOf } from "../controls.js";
import { memo } from "../pace.js";
import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Arm } from "../arm/panel.js";
import { armOf, namedPose } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import { nameJoint, type NamedPose, type Robot } from "../bank.js";
import { CopyButton, saveFile } from "../pages/copy-button.js";
import { listen } from "../scheduling.js";
import { getLanguage, textOf, say } from "../text/text.js";
import { convertAngles } from "./angles.js";
import { Editor } from "./editor.js";
import { Figures } from "./figures.js";
import { FormulasView } from "./formulas-view.js";
import { writeToml } from "./file.js";
import { type KnownArm, type KnownArms, makeTable } from "./known-arms.js";
import { writeFragment, parseFragment } from "./link.js";
import { makeRobot } from "./standard.js";
import { type Faults, makeRow, findUnitWarning, parseTable, type Table, ZEROS } from "./table.js";

/** The arm on the page. */
interface OwnState {
  readonly table: Table;
  /** The key of the known arm that the table describes; null for a typed table. */
  readonly robot: string | null;
  /** The pose in the link that led to the page (degrees or metres, joint by joint); null if there is none. */
  readonly pose: readonly number[] | null;
  /** The error in the link that led to the page. */
  readonly fault: "own.no-table" | "own.no-robot" | null;
}

/** A new table. */
const NEW_TABLE: Table = {
  ...{ name: "", convention: "dh", angles: "degrees", task: null },
  rows: [0, 1].map((row) => ({ ...makeRow("R", row), a: "0.5" })),
  ...{ tool: ZEROS, place: ZEROS, turn: ZEROS },
};
const NO_FAULTS: Faults = new Map();

export function OwnArm({ knownArms }: { knownArms: KnownArms }): JSX.Element {
  const allArms = useMemo(() => [...knownArms.plain, ...knownArms.robots], [knownArms]);
  const [state, setState] = useState<OwnState>(() => parseAddress(allArms));
  const [stage, setStage] = useState<Stage | null>(null);
  const numbers = useMemo(() => parseTable(state.table), [state.table]);
  const faults = numbers instanceof Map ? (numbers as Faults) : NO_FAULTS;
  const lastRobot = useRef<Robot | null>(null); // while a cell is invalid, the last arm is shown
  const robot = useMemo(() => {
    if (!("rows" in numbers)) return lastRobot.current;
    return (lastRobot.current = makeRobot(state.table, numbers));
  }, [state.table, numbers]);
  const defaultTask = useMemo(
    () => ("rows" in numbers ? makeRobot({ ...state.table, task: null }, numbers).task : []),
    [state.table, numbers],
  );
  const lastPose = useRef<NamedPose | undefined>(undefined);
  const jointKinds = state.table.rows.map(({ kind }) => kind).join("");
  const initialPose = useMemo(() => findLinkedPose(state) ?? keepFittingPose(robot, lastPose.current), [robot]);

  const followLink = (): void => {
    if (!window.location.hash.includes("=") || window.location.hash === writtenFragment.current) return;
    lastPose.current = undefined;
    setState(parseAddress(allArms));
  };
  useEffect(() => listen(window, "hashchange", followLink), [allArms]);

  const settledPose = stage?.settledState.pose;
  const fragment = writeFragment(
    state.table,
    state.robot,
    settledPose?.length === state.table.rows.length
      ? settledPose.map((value, i) => (state.table.rows[i]!.kind === "R" ? (value * 180) / Math.PI : value))
      : state.pose,
  );
  const writtenFragment = useRef("");
  useEffect(() => {
    if (state.fault) return; // an invalid link stays in the address until something is typed
    const { hash } = window.location;
    const isOtherLink = writtenFragment.current !== "" && hash !== writtenFragment.current && hash.includes("=");
    if (isOtherLink) return; // another link was followed; its hashchange event comes next
    writtenFragment.current = fragment;
    if (hash !== fragment) window.history.replaceState(null, "", fragment);
  }, [fragment, state.fault]);

  const changeTable = useCallback(
    (table: Table): void => {
      lastPose.current ??= initialPose ?? (stage ? namedPose(stage.arm, stage.pose) : undefined);
      setState({ table, robot: null, pose: null, fault: null });
    },
    [initialPose, stage?.pose],
  );
  const beginWith = useCallback(
    (key: string): void => {
      const knownArm = allArms.find((arm) => arm.key === key);
      if (key && !knownArm) return;
      lastPose.current = undefined;
      const table = convertAngles(knownArm ? makeTable(knownArm, getLanguage().code) : NEW_TABLE, state.table.angles);
      setState({ table, robot: knownArm ? key : null, pose: null, fault: null });
    },
    [allArms, state.table.angles],
  );
  const rememberPose = useCallback((next: NamedPose) => void (lastPose.current = next), []);
  const source = allArms.find(({ key }) => key === state.robot)?.source;
  const warning = "rows" in numbers ? findUnitWarning(numbers, state.table.angles) : null;
  return (
    <div class="workspace">
      <article class="task own">
        <h2>{say("own.title")}</h2>
        <p>
          <Words text={say("own.lead")} />
        </p>
        {state.fault ? (
          <p role="alert" class="own-alert">
            {say(state.fault)}
          </p>
        ) : null}
        <div class="own-begin">
          <Begin knownArms={knownArms} chosenKey={state.robot} onBegin={beginWith} />
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
          {faults.size > 0 ? say("own.wrong", { count: faults.size }) : warning ? textOf(warning) : ""}
        </p>
        {stage ? <Figures stage={stage} /> : null}
        {stage && "rows" in numbers && numbers.rows.length === stage.arm.joints.length ? (
          <FormulasView arm={stage.arm} rows={numbers.rows} />
        ) : null}
        <NextSteps table={state.table} link={`${window.location.href.split("#")[0]}${fragment}`} />
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        {robot ? (
          <Arm
            key={jointKinds}
            robot={robot}
            symbols={{}}
            pose={initialPose}
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

/** Return a pose if it has all joints of the robot, else undefined. */
function keepFittingPose(robot: Robot | null, pose: NamedPose | undefined): NamedPose | undefined {
  if (!robot || !pose) return undefined;
  return armOf(robot).joints.every(({ name }) => name in pose) ? pose : undefined;
}

/** Return the pose in the link by the names of the joints (rad or m); undefined if it does not fit the table. */
function findLinkedPose({ pose, table }: OwnState): NamedPose | undefined {
  if (pose?.length !== table.rows.length) return undefined;
  return Object.fromEntries(
    table.rows.map((row, i) => [nameJoint(row, i), row.kind === "R" ? (pose[i]! * Math.PI) / 180 : pose[i]!]),
  );
}

/** Return the arm that the address describes; the first known arm if it describes none. */
function parseAddress(allArms: readonly KnownArm[]): OwnState {
  const makeKnownTable = (arm: KnownArm): Table => convertAngles(makeTable(arm, getLanguage().code), NEW_TABLE.angles);
  const firstArm = { table: makeKnownTable(allArms[0]!), robot: allArms[0]!.key, pose: null };
  const content = parseFragment(window.location.hash);
  if (content === null) return { ...firstArm, fault: null };
  if (content === "unreadable") return { ...firstArm, fault: "own.no-table" };
  if (content.table) return { table: content.table, robot: null, pose: content.pose, fault: null };
  const robot = allArms.find(({ key }) => key === content.robot);
  if (!robot) return { ...firstArm, fault: "own.no-robot" };
  return { table: makeKnownTable(robot), robot: robot.key, pose: content.pose, fault: null };
}

interface BeginProps {
  readonly knownArms: KnownArms;
  /** The key of the arm with which the table began; null for a typed table. */
  readonly chosenKey: string | null;
  readonly onBegin: (key: string) => void;
}

// `memo`: the menu is not drawn again while the arm moves.
const Begin = memo((props: BeginProps): JSX.Element => {
  const { code } = getLanguage();
  const makeOptions = (arms: readonly KnownArm[]): Option[] =>
    arms.map(({ key, name, titles }) => [key, titles?.[code] ?? name]);
  return (
    <Choice label="own.begin" value={props.chosenKey ?? ""} any="own.typed" onValue={props.onBegin}>
      <optgroup label={say("own.plain")}>{optionsOf(makeOptions(props.knownArms.plain))}</optgroup>
      <optgroup label={say("own.robots")}>{optionsOf(makeOptions(props.knownArms.robots))}</optgroup>
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
    <p>
      <Words text={say("own.solve-says")} />
    </p>
    <pre>
      <code>qdot solve arm.toml</code>
    </pre>
    <p class="actions">
      <Button
        className="quiet small"
        text={say("own.save")}
        onClick={() => saveFile("arm.toml", "application/toml", writeToml(table))}
      />
    </p>
  </section>
));
