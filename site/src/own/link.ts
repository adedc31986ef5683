// A table and a pose as the end of an address, behind #, and back. Whatever stands there was typed by somebody: it is
// taken as text for cells, and what is no table is none.
//
//     #dh=R_q1_0_0.5_0~R_q2_0_0.4_0&at=30_45      a row is kind, theta, d, a, alpha; the pose in degrees and metres
//     #mdh=…&angles=degrees&tool=0_0_0.1&place=…&turn=…&task=vx_vy&name=…
//     #robot=panda
//
// Cells have no "~" and "_" but as %7E and %5F: these signs no program writes otherwise when it hands an address on.

import { ENTRIES, isTaskRow, LONGEST, MOST_JOINTS, type Table, type Triple, type TypedRow, ZEROS } from "./table.js";

/** What an address tells: a robot by its name, or a table; and a pose (degrees or metres, joint by joint). */
export interface Told {
  readonly robot: string | null;
  readonly table: Table | null;
  readonly at: readonly number[] | null;
}

const packed = (text: string): string =>
  encodeURIComponent(text).replace(/~/g, "%7E").replace(/_/g, "%5F").replace(/%20/g, "+");
const unpacked = (text: string): string => decodeURIComponent(text.replace(/\+/g, "%20"));

const KEYS = { dh: "dh", "modified-dh": "mdh" } as const;

/** The end of an address for a table, or for a robot of the library as it is there. */
export function asFragment(table: Table, robot: string | null, at: readonly number[] | null): string {
  const pose = at ? [`at=${at.map((value) => String(Number(value.toFixed(4)))).join("_")}`] : [];
  if (robot !== null) return `#${[`robot=${packed(robot)}`, ...pose].join("&")}`;
  const rows = table.rows.map((row) => [row.kind, ...ENTRIES.map((entry) => packed(row[entry]))].join("_"));
  const three = (name: "tool" | "place" | "turn"): string[] =>
    table[name].every((text) => text.trim() === "0") ? [] : [`${name}=${table[name].map(packed).join("_")}`];
  return `#${[
    `${KEYS[table.convention]}=${rows.join("~")}`,
    ...(table.angles === "degrees" ? ["angles=degrees"] : []),
    ...three("tool"),
    ...three("place"),
    ...three("turn"),
    ...(table.task ? [`task=${table.task.join("_")}`] : []),
    ...(table.name ? [`name=${packed(table.name)}`] : []),
    ...pose,
  ].join("&")}`;
}

/** What the end of an address tells; null where there is nothing, "unreadable" where it is no table. */
export function fromFragment(fragment: string): Told | null | "unreadable" {
  const text = fragment.replace(/^#/, "");
  if (!text.includes("=")) return null; // the way to the content, and the like
  if (text.length > 20_000) return "unreadable";
  const found = new Map<string, string>();
  for (const pair of text.split("&")) {
    const cut = pair.indexOf("=");
    if (cut > 0) found.set(pair.slice(0, cut), pair.slice(cut + 1));
  }
  try {
    return told(found);
  } catch (error) {
    if (error instanceof URIError || error instanceof NoTable) return "unreadable";
    throw error;
  }
}

class NoTable extends Error {}

function told(found: ReadonlyMap<string, string>): Told {
  const at = numbers(found.get("at"));
  const robot = found.get("robot");
  if (robot !== undefined) return { robot: cell(robot), table: null, at };
  const convention = found.has("dh") ? "dh" : "modified-dh";
  const rows = (found.get(KEYS[convention]) ?? "").split("~").map(rowOf);
  if (rows.length > MOST_JOINTS) throw new NoTable();
  const task = found.get("task")?.split("_").filter(isTaskRow) ?? [];
  const table: Table = {
    name: cell(found.get("name") ?? ""),
    convention,
    angles: found.get("angles") === "degrees" ? "degrees" : "radians",
    rows,
    tool: three(found.get("tool")),
    place: three(found.get("place")),
    turn: three(found.get("turn")),
    task: task.length > 0 ? [...new Set(task)] : null,
  };
  return { robot: null, table, at: at?.length === rows.length ? at : null };
}

function rowOf(text: string): TypedRow {
  const [kind, theta, d, a, alpha, more] = text.split("_");
  if ((kind !== "R" && kind !== "P") || alpha === undefined || more !== undefined) throw new NoTable();
  return { kind, theta: cell(theta!), d: cell(d!), a: cell(a!), alpha: cell(alpha) };
}

/** A cell's text in one line. */
function cell(text: string): string {
  const plain = unpacked(text).replace(/\s+/gu, " ").trim();
  if (plain.length > LONGEST) throw new NoTable();
  return plain;
}

function three(text: string | undefined): Triple<string> {
  if (text === undefined) return ZEROS;
  const [x, y, z, more] = text.split("_").map(cell);
  if (z === undefined || more !== undefined) throw new NoTable();
  return [x!, y!, z];
}

/** The numbers of a pose; null where they are none. */
function numbers(text: string | undefined): number[] | null {
  const values = (text ?? "").split("_").map((value) => (value.trim() === "" ? NaN : Number(value)));
  return values.every((value) => Number.isFinite(value) && Math.abs(value) < 1e6) ? values : null;
}
