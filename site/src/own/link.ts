// Write a table and a pose as the end of an address, behind #, and parse it. Anyone may have typed the address, so its
// cells are treated as mere text, and an invalid table is refused.
//
//     #dh=R_q1_0_0.5_0~R_q2_0_0.4_0&at=30_45      a row is kind, theta, d, a, alpha; the pose in degrees and metres
//     #mdh=…&angles=degrees&tool=0_0_0.1&place=…&turn=…&task=vx_vy&name=…
//     #robot=panda
//
// Cells contain "~" and "_" only as %7E and %5F: no program that passes an address on changes these two escapes.

import type { Table, Triple, TypedRow } from "./table.js";
import { ENTRIES, isTaskRow, MAX_CHARACTERS, MAX_JOINTS, ZEROS } from "./table.js";

/** The content of an address: a known robot's key, or a table; and a pose (degrees or metres, joint by joint). */
export interface Fragment {
  readonly robot: string | null;
  readonly table: Table | null;
  readonly pose: readonly number[] | null;
}

const encode = (text: string): string =>
  encodeURIComponent(text).replace(/~/g, "%7E").replace(/_/g, "%5F").replace(/%20/g, "+");
const decode = (text: string): string => decodeURIComponent(text.replace(/\+/g, "%20"));

const CONVENTION_KEYS = { dh: "dh", "modified-dh": "mdh" } as const;

/** Return the end of an address for a table, or for a known robot; the pose is in degrees or metres. */
export function writeFragment(table: Table, robot: string | null, pose: readonly number[] | null): string {
  const poseParameters = pose ? [`at=${pose.map((value) => String(Number(value.toFixed(4)))).join("_")}`] : [];
  if (robot !== null) return `#${[`robot=${encode(robot)}`, ...poseParameters].join("&")}`;
  const rows = table.rows.map((row) => [row.kind, ...ENTRIES.map((entry) => encode(row[entry]))].join("_"));
  const listTripleParameter = (name: "tool" | "place" | "turn"): string[] =>
    table[name].every((text) => text.trim() === "0") ? [] : [`${name}=${table[name].map(encode).join("_")}`];
  return `#${[
    `${CONVENTION_KEYS[table.convention]}=${rows.join("~")}`,
    ...(table.angles === "degrees" ? ["angles=degrees"] : []),
    ...listTripleParameter("tool"),
    ...listTripleParameter("place"),
    ...listTripleParameter("turn"),
    ...(table.task ? [`task=${table.task.join("_")}`] : []),
    ...(table.name ? [`name=${encode(table.name)}`] : []),
    ...poseParameters,
  ].join("&")}`;
}

/** Parse the end of an address; return null if it is empty, "unreadable" if it is invalid. */
export function parseFragment(fragment: string): Fragment | null | "unreadable" {
  const text = fragment.replace(/^#/, "");
  if (!text.includes("=")) return null; // another link within the page
  if (text.length > 20_000) return "unreadable";
  const values = new Map<string, string>();
  for (const pair of text.split("&")) {
    const equalsIndex = pair.indexOf("=");
    if (equalsIndex > 0) values.set(pair.slice(0, equalsIndex), pair.slice(equalsIndex + 1));
  }
  try {
    return parseValues(values);
  } catch (error) {
    if (error instanceof URIError || error instanceof InvalidTable) return "unreadable";
    throw error;
  }
}

class InvalidTable extends Error {}

function parseValues(values: ReadonlyMap<string, string>): Fragment {
  const pose = parsePose(values.get("at"));
  const robot = values.get("robot");
  if (robot !== undefined) return { robot: parseCell(robot), table: null, pose };
  const convention = values.has("dh") ? "dh" : "modified-dh";
  const rows = (values.get(CONVENTION_KEYS[convention]) ?? "").split("~").map(parseRow);
  if (rows.length > MAX_JOINTS) throw new InvalidTable();
  const task = values.get("task")?.split("_").filter(isTaskRow) ?? [];
  const table: Table = {
    name: parseCell(values.get("name") ?? ""),
    convention,
    angles: values.get("angles") === "degrees" ? "degrees" : "radians",
    rows,
    tool: parseTriple(values.get("tool")),
    place: parseTriple(values.get("place")),
    turn: parseTriple(values.get("turn")),
    task: task.length > 0 ? [...new Set(task)] : null,
  };
  return { robot: null, table, pose: pose?.length === rows.length ? pose : null };
}

function parseRow(text: string): TypedRow {
  const [kind, theta, d, a, alpha, extraCell] = text.split("_");
  if ((kind !== "R" && kind !== "P") || alpha === undefined || extraCell !== undefined) throw new InvalidTable();
  return { kind, theta: parseCell(theta!), d: parseCell(d!), a: parseCell(a!), alpha: parseCell(alpha) };
}

/** Decode the text of a cell as one line. */
function parseCell(text: string): string {
  const plain = decode(text).replace(/\s+/gu, " ").trim();
  if (plain.length > MAX_CHARACTERS) throw new InvalidTable();
  return plain;
}

function parseTriple(text: string | undefined): Triple<string> {
  if (text === undefined) return ZEROS;
  const [x, y, z, extraCell] = text.split("_").map(parseCell);
  if (z === undefined || extraCell !== undefined) throw new InvalidTable();
  return [x!, y!, z];
}

/** Parse the numbers of a pose; null if they are invalid. */
function parsePose(text: string | undefined): number[] | null {
  const values = (text ?? "").split("_").map((value) => (value.trim() === "" ? NaN : Number(value)));
  return values.every((value) => Number.isFinite(value) && Math.abs(value) < 1e6) ? values : null;
}
