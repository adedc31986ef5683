"""Write cells with which students check their answers against each other, without access to the correct answers.

The file relations.toml has equations between answers, in Python code for the cell that a student runs. The function
that the cell calls (`templates/notebook/self-check.py.j2`) is in the notebook and needs only SymPy and NumPy.
"""

import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.formula.printers.python import python_text
from qdot.exercises.problem.problem import Part, Problem, answer_variable
from qdot.exercises.writing.render import render

SELF_CHECK = "self_check"
"""Prefix of all names that belong to the checks."""

Problems = Sequence[tuple[str, Problem]]
"""The problems of a notebook with their slots, p1, p2, …"""
PartsByKind = dict[str, Part]
"""The parts of a problem by their kind of question."""


def _coordinate_indices(parts: PartsByKind) -> list[int]:
    """Return the indices of the coordinates x, y, z that the question on position asks for."""
    return ["xyz".index(axis) for axis in getattr(parts["position"].details, "axes", "xyz")]


def _is_point_last_origin(chain: Chain, _: PartsByKind) -> bool:
    point = convention_of(chain).point
    return point.frame == chain.n and point.is_origin


CONDITIONS: dict[str, Callable[[Chain, PartsByKind], bool]] = {
    "square": lambda chain, _: len(chain.task) == chain.n,
    "all-revolute": lambda chain, _: chain.point.frame == chain.n and {joint.kind for joint in chain.joints} == {"R"},
    "all-task-rows": lambda chain, parts: getattr(parts["jacobian"].details, "task", chain.task) == chain.task,
    "linear-rows-first": lambda chain, _: [row[0] for row in chain.task] == sorted(row[0] for row in chain.task),
    "all-linear-rows": lambda chain, parts: len(_coordinate_indices(parts)) == len(chain.linear_axes) > 0,
    "point-last-origin": _is_point_last_origin,
    "point-not-last-origin": lambda chain, parts: not _is_point_last_origin(chain, parts),
}
"""The conditions under which a relation applies to an arm and its questions, by name."""


@dataclass(frozen=True)
class Relation:
    """An equation between answers to several questions: Python code for its left and its right side.

    In the code, `{position}` stands for the answer on position. `at` is a random configuration: `at(answer)` are the
    values of an answer there, and `at.slope(answer)` its derivatives with respect to the joint variables. `needs` are
    the questions whose answers occur, and `question` is what the check prints. The equation applies to an arm if all
    `conditions` hold. `is_singular_set` means that the left side is a singular set, which is checked against a
    Jacobian.
    """

    needs: list[str]
    question: str
    left_code: str
    right_code: str
    conditions: tuple[str, ...] = ()
    is_singular_set: bool = False

    def applies(self, chain: Chain, parts: PartsByKind) -> bool:
        """Return whether the equation applies to an arm and its questions."""
        return all(CONDITIONS[name](chain, parts) for name in self.conditions)


RELATIONS_FILE = Path(__file__).with_name("relations.toml")
RELATIONS = [Relation(**entry) for entry in tomllib.loads(RELATIONS_FILE.read_text(encoding="utf-8"))["relation"]]
"""All relations. If several can be checked after the same question, they are checked in this order."""


def _find_relations(problem: Problem) -> Iterator[tuple[str, Relation]]:
    """Yield each relation that can be checked with the name of the last part that it needs."""
    parts, order = _parts_by_kind(problem), [part.name for part in problem.parts]
    for relation in RELATIONS:
        if all(kind in parts for kind in relation.needs) and relation.applies(problem.chain, parts):
            yield max((parts[kind].name for kind in relation.needs), key=order.index), relation


def _parts_by_kind(problem: Problem) -> PartsByKind:
    """Return the parts by their kind of question, without parts that ask the same at a given configuration."""
    return {part.kind: part for part in reversed(problem.parts) if part.name == part.kind}


def check_cell(slot: str, problem: Problem, part: str) -> str:
    """Return the cell with the checks that become possible with an answer to a part, or "" if there are none."""
    relations = [relation for name, relation in _find_relations(problem) if name == part]
    if not relations:
        return ""
    parts, omega_first = _parts_by_kind(problem), convention_of(problem.chain).is_omega_first
    linear_half, angular_half, in_order = ("3:", ":3", "") if omega_first else (":3", "3:", "[np.r_[3:6, 0:3]]")
    placeholders: dict[str, object] = {
        "linear_half": linear_half, "angular_half": angular_half, "in_order": in_order,
        "n": problem.chain.n, "linear": len(problem.chain.linear_axes),
        "rows": _coordinate_indices(parts) if "position" in parts else [],
        "turning": [int(joint.is_revolute) for joint in problem.chain.joints],
        **{kind.replace("-", "_"): answer_variable(slot, part_of_kind.name) for kind, part_of_kind in parts.items()},
    }  # fmt: skip
    codes = [
        (relation, relation.left_code.format(**placeholders), relation.right_code.format(**placeholders))
        for relation in relations
    ]
    return render("notebook/check.py.j2", slot=slot, checks=codes).strip()


def function_cell(problems: Problems) -> str:
    """Return the cell with the function that the checks call, or "" if no problem has any checks."""
    checked_problems = [
        (slot, _names_by_role(problem), _given_values(problem))
        for slot, problem in problems
        if any(_find_relations(problem))
    ]
    return render("notebook/self-check.py.j2", problems=checked_problems).strip() if checked_problems else ""


def _names_by_role(problem: Problem) -> list[tuple[str, list[str]]]:
    roles: dict[str, list[str]] = {"joint": [], "rate": [], "velocity": [], "load": []}
    for name, info in problem.symbols().items():
        role = "load" if info.role in ("force", "moment") else info.role
        roles.setdefault(role, []).append(name)
    return list(roles.items())


def _given_values(problem: Problem) -> list[tuple[str, str]]:
    return [(name, python_text(i.value)) for name, i in problem.symbols().items() if i.value is not None]


def self_check_cells(problems: Problems) -> tuple[str, frozenset[str]]:
    """Return the function's cell and the set of the checks' cells, as in a notebook."""
    cells = {check_cell(slot, problem, part.name) for slot, problem in problems for part in problem.parts}
    return function_cell(problems), frozenset(cells - {""})
