"""Arms entered on the site, with Python's results for the site's tests: `python -m tests.tools.site_arms`.

site/tests/arms.json has tables in the form of the site's page for arms, the ROBOT.toml that the page writes, the
default task, and J at a pose with its determinant and singular values, computed directly from the table. If `qdot
solve` reads this ROBOT.toml, the arm has the same J except for rounding in the file.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.robots.entry import parse_entry
from qdot.exercises.robots.robot_file import ENTRY_KEYS, read_robot_file
from qdot.exercises.site.robots import ZERO_VECTOR, make_tables_json
from tests.support import ROOT

TARGET = ROOT / "site" / "tests" / "arms.json"
Table = dict[str, Any]


def make_arms_text() -> str:
    robots = json.loads(make_tables_json())
    stored_tables = [arm["table"] for arm in json.loads(TARGET.read_text(encoding="utf-8"))]
    random_tables = [table for table in stored_tables if table["name"].startswith("drawn")]  # of two to seven joints
    tables = [*robots["plain"], *robots["robots"], *random_tables]
    cases = [json.dumps(_make_case(table, f"arm/{i}"), ensure_ascii=False) for i, table in enumerate(tables)]
    return "[\n" + ",\n".join(cases) + "\n]\n"


def _make_case(table: Table, name: str) -> dict[str, Any]:
    stored_table = {key: value for key, value in table.items() if key not in ("key", "titles", "source")}
    toml = write_robot_toml(stored_table)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(toml, encoding="utf-8")
        robot = read_robot_file(path)
    chain, stream = robot.chain, Stream(name)
    q = [round(stream.uniform(-3, 3) if joint.is_revolute else stream.uniform(0.1, 1), 3) for joint in chain.joints]
    jacobian = compute_jacobian(stored_table, q)
    error = np.abs(jacobian - NumericChain(chain, {}).compute_jacobian(np.array(q))).max()
    if error > (1e-8 if robot.is_table_rounded else 1e-12):
        raise AssertionError(f"{name}: the arm read from the file differs from the table by {error}")
    task_rows = jacobian[[VELOCITY_NAMES.index(row) for row in chain.task]]
    is_square = task_rows.shape[0] == task_rows.shape[1]
    return {
        "table": stored_table,
        "toml": toml,
        "task": list(chain.task),
        "q": q,
        "jacobian": jacobian.tolist(),
        "det": float(np.linalg.det(task_rows)) if is_square else None,
        "sigma": np.linalg.svd(task_rows, compute_uv=False).tolist(),
    }


def compute_jacobian(table: Table, q: list[float]) -> np.ndarray:
    """Return the 6 x n Jacobian of a table from the product of its rows, without converting the table."""
    in_degrees, is_modified = table["angles"] == "degrees", table["convention"] == "modified-dh"

    def number(text: str, is_angle: bool, q_i: float = 0.0, i: int = 0) -> float:
        value = parse_entry(text, is_angle, in_degrees)
        return float(value.subs(sp.Symbol(f"q{i}"), sp.Float(q_i, 30)).evalf(30))

    roll, pitch, yaw = (number(text, True) for text in table["turn"])
    pose = _translate(*(number(text, False) for text in table["place"])) @ _rotate(2, yaw) @ _rotate(1, pitch)
    pose = pose @ _rotate(0, roll)
    axes = []
    for i, (row, q_i) in enumerate(zip(table["rows"], q, strict=True), 1):
        theta, alpha = (number(row[key], True, q_i, i) for key in ("theta", "alpha"))
        d, a = (number(row[key], False, q_i, i) for key in ("d", "a"))
        about_x, about_z = _rotate(0, alpha) @ _translate(a, 0, 0), _rotate(2, theta) @ _translate(0, 0, d)
        pose = pose @ about_x if is_modified else pose
        is_revolute = row["kind"] == "R"
        variable = row["theta" if is_revolute else "d"]
        sign = number(variable, is_revolute, 1, i) - number(variable, is_revolute, 0, i)
        axes.append((row["kind"], np.sign(sign) * pose[:3, 2], pose[:3, 3]))
        pose = pose @ about_z if is_modified else pose @ about_z @ about_x
    point = (pose @ _translate(*(number(text, False) for text in table["tool"])))[:3, 3]
    columns = [
        np.concatenate([np.cross(z, point - o), z] if joint_type == "R" else [z, np.zeros(3)])
        for joint_type, z, o in axes
    ]
    return np.column_stack(columns)


def _rotate(axis: int, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    pose, (i, j) = np.eye(4), [(1, 2), (2, 0), (0, 1)][axis]
    pose[i, i], pose[i, j], pose[j, i], pose[j, j] = c, -s, s, c
    return pose


def _translate(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def write_robot_toml(table: Table) -> str:
    settings = {
        key: table[key] for key, default in (("convention", "dh"), ("angles", "radians")) if table[key] != default
    }
    base = {key: table[name] for key, name in (("position", "place"), ("rpy", "turn")) if table[name] != ZERO_VECTOR}
    lines = [
        f"name = {json.dumps(table['name'])}",
        *(f"{key} = {json.dumps(value)}" for key, value in settings.items()),
    ]
    if table["task"]:
        lines.append(f"task = {json.dumps(table['task'])}")
    if table["tool"] != ZERO_VECTOR:
        lines.append(f"tool = {{position = {json.dumps(table['tool'])}}}")
    if base:
        lines.append("base = {" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in base.items()) + "}")
    for row in table["rows"]:
        lines += ["", "[[joint]]", *(f'{key} = "{row[key]}"' for key in ("kind", *ENTRY_KEYS))]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    write_atomically(TARGET, make_arms_text())
