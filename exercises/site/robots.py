"""Make example tables for the page "Your own arm": the chapter's arms with numeric values, and real robots.

A table has the page's format (site/src/own/table.ts): {"name", "convention", "angles", "rows": [{"kind", "theta", "d",
"a", "alpha"}], "tool", "place", "turn", "task"}. "place" and "turn" are the position and the roll-pitch-yaw angles of
the base. Entries are texts in the notation for typing.
"""

import json
from collections.abc import Iterator, Mapping
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.input_file import read_toml
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.pose import choose_example_values
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.problem.record import Json
from qdot.exercises.robots.library import list_robots
from qdot.exercises.robots.robot_file import ENTRY_KEYS
from qdot.exercises.writing.languages import LANGUAGES, load_catalogue

PLAIN_FAMILIES = ("planar-2r", "scara", "elbow-3r", "spherical", "anthropomorphic-6r")
"""Families whose arms from the chapter are at the top of the list."""
ZERO_VECTOR = ["0", "0", "0"]


def make_tables_json() -> str:
    """Return the JSON text of all tables: {"format": 1, "plain": [table], "robots": [table with its source]}."""
    content = {"format": 1, "plain": [*_make_plain_tables()], "robots": [*_make_library_tables()]}
    return json.dumps(content, ensure_ascii=False, separators=(",", ":"))


def _make_plain_tables() -> Iterator[Json]:
    """Yield the tables of the chapter's arms of PLAIN_FAMILIES."""
    for name in PLAIN_FAMILIES:
        chain = sample_chain(ProblemId(name, 0, variation="chapter"))
        title = FAMILIES[name].title
        translations = {code: load_catalogue(code).translate_family(title) for code in LANGUAGES}
        yield {"key": name, "titles": translations, **_make_table_of_chain(chain, title)}


def _make_table_of_chain(chain: Chain, title: str) -> Json:
    """Return a chain's standard DH table with the values that the chain's figure shows; angles are in radians."""
    values: dict[sp.Basic, sp.Expr] = {
        symbol: sp.Float(value) for symbol, value in choose_example_values(chain).items()
    }
    rows = []
    for i, joint in enumerate(chain.joints, 1):
        row = {key: _write_entry(getattr(joint, key).xreplace(values), i) for key in ENTRY_KEYS}
        rows.append({"kind": joint.kind, **row})
    point = [_write_entry(value.xreplace(values), 0) for value in chain.point.offset]
    return _complete_table(title, {"rows": rows, "tool": point, "task": list(chain.task)})


def _write_entry(value: sp.Expr, joint_number: int) -> str:
    """Return a table entry in the notation for typing: the variable of joint i is qi, and numbers have six digits."""
    joint_names = {sp.Symbol(f"{name}{joint_number}"): sp.Symbol(f"q{joint_number}") for name in ("theta", "d")}
    rounded_numbers = {number: sp.Float(f"{float(number):.6g}") for number in value.atoms(sp.Float)}
    shortened_value = value.xreplace(joint_names).xreplace(rounded_numbers)
    return f"{float(shortened_value):.6g}" if shortened_value.is_Float else str(shortened_value)


def _complete_table(name: str, fields: Mapping[str, Any]) -> Json:
    """Return a table with these fields, and with the defaults of all others."""
    vectors = dict.fromkeys(("tool", "place", "turn"), ZERO_VECTOR)
    return {"name": name, "convention": "dh", "angles": "radians", **vectors, "task": None, **fields}


def _make_library_tables() -> Iterator[Json]:
    """Yield the tables of the library's robots, with the entries in their files."""
    for name, robot in list_robots().items():
        content = read_toml(robot.path).content
        rows = [{key: str(row[key]) for key in ("kind", *ENTRY_KEYS)} for row in content["joint"]]
        base = content.get("base", {})
        fields = {
            "rows": rows,
            **{key: content[key] for key in ("convention", "angles", "task") if key in content},
            **({"tool": [*map(str, content["tool"]["position"])]} if "tool" in content else {}),
            **({"place": [*map(str, base["position"])]} if "position" in base else {}),
            **({"turn": [*map(str, base["rpy"])]} if "rpy" in base else {}),
        }
        yield {"key": name, "source": robot.source, **_complete_table(robot.title, fields)}
