"""Arms that people tell the site, and what Python makes of them: `python -m tests.tools.site_arms`.

arms.json in site/tests has tables as the page of one's own arm keeps them, the ROBOT.toml that the page writes of
each, the usual task, and J at a pose with its determinant and singular values, worked out from the table as it is
written. The same arm, read from that file as `qdot solve` reads it, has the same J, but for what is rounded there.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.entry import parse_entry
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.robot_file import ROW_KEYS, read_robot_file
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.site.robots import ZERO_VECTOR, robots_text
from tests.support import ROOT

TARGET = ROOT / "site" / "tests" / "arms.json"
DRAWN = 40
Table = dict[str, Any]


def arms_text() -> str:
    """Return the file's text, an arm a line."""
    known = json.loads(robots_text())
    tables = [*known["plain"], *known["robots"], *map(_drawn, range(DRAWN))]
    cases = [json.dumps(_case(table, f"arm/{i}"), ensure_ascii=False) for i, table in enumerate(tables)]
    return "[\n" + ",\n".join(cases) + "\n]\n"


def _case(table: Table, name: str) -> dict[str, Any]:
    kept = {key: value for key, value in table.items() if key not in ("key", "titles", "source")}
    toml = toml_text(kept)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(toml, encoding="utf-8")
        robot = read_robot_file(path)
    chain, stream = robot.chain, Stream(name)
    q = [round(stream.uniform(-3, 3) if joint.is_revolute else stream.uniform(0.1, 1), 3) for joint in chain.joints]
    whole = as_written(kept, q)
    off = np.abs(whole - NumericChain(chain, {}).jacobian(np.array(q))).max()
    if off > (1e-8 if robot.is_table_rounded else 1e-12):
        raise AssertionError(f"{name}: the arm that is read is another than the table that is written, by {off}")
    counted = whole[[VELOCITY_NAMES.index(row) for row in chain.task]]
    square = counted.shape[0] == counted.shape[1]
    return {
        "table": kept,
        "toml": toml,
        "task": list(chain.task),
        "q": q,
        "jacobian": whole.tolist(),
        "det": float(np.linalg.det(counted)) if square else None,
        "sigma": np.linalg.svd(counted, compute_uv=False).tolist(),
    }


def as_written(table: Table, q: list[float]) -> np.ndarray:
    """Return the 6 x n Jacobian of a table as it is written: products of its rows, no other table in between."""
    in_degrees, is_modified = table["angles"] == "degrees", table["convention"] == "modified-dh"

    def number(text: str, is_angle: bool, own: float = 0.0, i: int = 0) -> float:
        value = parse_entry(text, is_angle, in_degrees)
        return float(value.subs(sp.Symbol(f"q{i}"), sp.Float(own, 30)).evalf(30))

    roll, pitch, yaw = (number(text, True) for text in table["turn"])
    pose = _moved(*(number(text, False) for text in table["place"])) @ _turned(2, yaw) @ _turned(1, pitch)
    pose = pose @ _turned(0, roll)
    axes = []
    for i, (row, own) in enumerate(zip(table["rows"], q, strict=True), 1):
        theta, alpha = (number(row[key], True, own, i) for key in ("theta", "alpha"))
        d, a = (number(row[key], False, own, i) for key in ("d", "a"))
        about_x, about_z = _turned(0, alpha) @ _moved(a, 0, 0), _turned(2, theta) @ _moved(0, 0, d)
        pose = pose @ about_x if is_modified else pose
        moving = "theta" if row["kind"] == "R" else "d"
        sign = number(row[moving], row["kind"] == "R", 1, i) - number(row[moving], row["kind"] == "R", 0, i)
        axes.append((row["kind"], np.sign(sign) * pose[:3, 2], pose[:3, 3]))
        pose = pose @ about_z if is_modified else pose @ about_z @ about_x
    point = (pose @ _moved(*(number(text, False) for text in table["tool"])))[:3, 3]
    columns = [
        np.concatenate([np.cross(z, point - o), z]) if kind == "R" else np.concatenate([z, np.zeros(3)])
        for kind, z, o in axes
    ]
    return np.column_stack(columns)


def _turned(axis: int, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    pose, (i, j) = np.eye(4), [(1, 2), (2, 0), (0, 1)][axis]
    pose[i, i], pose[i, j], pose[j, i], pose[j, j] = c, -s, s, c
    return pose


def _moved(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def toml_text(table: Table) -> str:
    """Return the ROBOT.toml that tells a table."""
    told = {key: table[key] for key, usual in (("convention", "dh"), ("angles", "radians")) if table[key] != usual}
    base = {key: table[name] for key, name in (("position", "place"), ("rpy", "turn")) if table[name] != ZERO_VECTOR}
    lines = [f"name = {json.dumps(table['name'])}", *(f"{key} = {json.dumps(value)}" for key, value in told.items())]
    if table["task"]:
        lines.append(f"task = {json.dumps(table['task'])}")
    if table["tool"] != ZERO_VECTOR:
        lines.append(f"tool = {{position = {json.dumps(table['tool'])}}}")
    if base:
        lines.append("base = {" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in base.items()) + "}")
    for row in table["rows"]:
        lines += ["", "[[joint]]", *(f'{key} = "{row[key]}"' for key in ROW_KEYS)]
    return "\n".join(lines) + "\n"


def _drawn(seed: int) -> Table:
    """Return a table of an arm that nobody built: two to seven joints, turned and moved in every way."""
    stream = Stream(f"site/arms/{seed}")

    def one_of(*choices: str) -> str:
        return choices[stream.integer_below(len(choices))]

    def length() -> str:
        return one_of("0", "0", f"{stream.uniform(-0.5, 0.9):.3f}", "1/3", "sqrt(2)/4", "0.3 + 0.1", "3/8 - 0.05")

    in_degrees = stream.integer_below(2) == 0

    def angle() -> str:
        if in_degrees:
            return one_of("0", "90", "-90", "180", "45", f"{stream.uniform(-170, 170):.1f}", "-37.5", "180/7")
        return one_of("0", "pi/2", "-pi/2", "pi", "pi/4", "2*pi/5", "-0.4", "pi/2 - 0.1", "atan2(1, 2)", "acos(1/3)")

    def moving(i: int, rest: str) -> str:
        sign = one_of("", "", "-")
        return f"{sign}q{i}" if rest == "0" else f"{sign}q{i} {'- ' if rest[0] == '-' else '+ '}{rest.lstrip('-')}"

    rows = []
    for i in range(1, 3 + stream.integer_below(6)):
        row = {"kind": one_of("R", "R", "R", "P"), "theta": angle(), "d": length(), "a": length(), "alpha": angle()}
        own = "theta" if row["kind"] == "R" else "d"
        rows.append({**row, own: moving(i, row[own])})
    return {
        "name": f'drawn "{seed}"',
        "convention": one_of("dh", "modified-dh"),
        "angles": "degrees" if in_degrees else "radians",
        "rows": rows,
        "tool": [length(), length(), length()],
        "place": [length(), length(), length()],
        "turn": [angle(), angle(), angle()] if stream.integer_below(2) else ZERO_VECTOR,
        "task": None,
    }


if __name__ == "__main__":
    write_atomically(TARGET, arms_text())
