"""Write the last cell of a notebook, which compares a student's answers with each other, without the correct ones.

The file relations.toml has the equations between answers, as Python code for the cell (`templates/notebook/
self-check.py.j2`). The cell needs only SymPy and NumPy.
"""

import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.writing.render import render

SELF_CHECK = "self_check"
"""The prefix of all names that the cell defines."""

Problems = Sequence[tuple[str, Problem]]
"""The problems of a notebook, each with its slot: p1, p2, …"""
PartsByKind = dict[str, Part]
"""Maps the name of each question of a problem to the part that asks it."""


def _list_coordinate_indices(parts: PartsByKind) -> list[int]:
    """Return the indices (from 0) of the coordinates x, y, z that the question on position asks for."""
    return ["xyz".index(axis) for axis in getattr(parts["position"].details, "axes", "xyz")]


def _is_point_last_origin(chain: Chain, _: PartsByKind) -> bool:
    """Return whether the point P is the origin of the last frame, in the convention that describes the arm."""
    point = convention_of(chain).point
    return point.frame == chain.n and point.is_origin


CONDITIONS: dict[str, Callable[[Chain, PartsByKind], bool]] = {
    "square": lambda chain, _: chain.has_square_jacobian,
    "all-revolute-and-point-last": lambda chain, _: chain.point.frame == chain.n and not chain.prismatic_joints,
    "all-task-rows": lambda chain, parts: getattr(parts["jacobian"].details, "task", chain.task) == chain.task,
    "linear-rows-first": lambda chain, _: [row[0] for row in chain.task] == sorted(row[0] for row in chain.task),
    "all-linear-rows": lambda chain, parts: len(_list_coordinate_indices(parts)) == len(chain.linear_axes) > 0,
    "point-last-origin": _is_point_last_origin,
    "point-not-last-origin": lambda chain, parts: not _is_point_last_origin(chain, parts),
}
"""Maps the name of a condition to the function that returns whether it holds for an arm and the parts of its problem.

A relation applies only to arms for which all of the relation's conditions hold.
"""


@dataclass(frozen=True)
class Relation:
    """An equation between the answers to several questions.

    - `questions` are the questions whose answers occur in the equation.
    - `printed_question` is the text that the check prints, such as "Is your velocity the derivative of your position?"
    - `left_code` and `right_code` are Python code for the two sides. In the code, `{position}` stands for the answer to
      the question on position. `at` is a random configuration: `at(answer)` are the values of an answer there, and
      `at.slope(answer)` are its derivatives with respect to the joint variables.
    - `conditions` are keys of CONDITIONS. The equation applies to an arm if all of them hold.
    - `is_singular_set` means that the left side is a set of singular configurations, and the right side a Jacobian.
    """

    questions: list[str]
    printed_question: str
    left_code: str
    right_code: str
    conditions: tuple[str, ...] = ()
    is_singular_set: bool = False

    def applies_to(self, chain: Chain, parts: PartsByKind) -> bool:
        """Return whether the equation applies to an arm and the parts of a problem."""
        return all(CONDITIONS[name](chain, parts) for name in self.conditions)


RELATIONS_FILE = Path(__file__).with_name("relations.toml")
RELATIONS = [Relation(**entry) for entry in tomllib.loads(RELATIONS_FILE.read_text(encoding="utf-8"))["relation"]]
"""All relations. If several can be checked after the same question, they are checked in this order."""


def _find_relations(problem: Problem) -> Iterator[tuple[str, Relation]]:
    """Yield the relations that apply to a problem, each with the name of the last part that it compares."""
    parts = {part.kind: part for part in problem.parts}
    for relation in RELATIONS:
        if all(kind in parts for kind in relation.questions) and relation.applies_to(problem.chain, parts):
            yield parts[max(relation.questions, key=list(parts).index)].name, relation


class _Check(NamedTuple):
    """A check in the cell: the number of the question, the slot, the relation, and the code of its two sides."""

    number: str
    slot: str
    relation: Relation
    left_code: str
    right_code: str


def write_self_check_cell(problems: Problems) -> str:
    """Return the cell with all checks of a notebook with these problems, or "" if there are none."""
    checks = [
        check for number, (slot, problem) in enumerate(problems, 1) for check in _list_checks(number, slot, problem)
    ]
    if not checks:
        return ""
    numbers = {
        f"{number}.{index}"
        for number, (_, problem) in enumerate(problems, 1)
        for index in range(1, len(problem.parts) + 1)
    }
    unchecked_numbers = sorted(numbers - _list_compared_numbers(problems))
    return render(
        "notebook/self-check.py.j2", problems=_list_symbols(problems), checks=checks,
        unchecked_numbers=unchecked_numbers,
    ).strip()  # fmt: skip


def _list_checks(number: int, slot: str, problem: Problem) -> list[_Check]:
    """Return the checks of a problem in the order of its questions."""
    parts = {part.kind: part for part in problem.parts}
    is_omega_first = convention_of(problem.chain).is_omega_first
    linear_half, angular_half = ("3:", ":3") if is_omega_first else (":3", "3:")
    linear_first_index = "" if is_omega_first else "[np.r_[3:6, 0:3]]"  # moves the three linear rows to the top
    placeholders: dict[str, object] = {
        "linear_half": linear_half, "angular_half": angular_half, "linear_first_index": linear_first_index,
        "n": problem.chain.n, "linear": len(problem.chain.linear_axes),
        "rows": _list_coordinate_indices(parts) if "position" in parts else [],
        "is_revolute": [int(joint.is_revolute) for joint in problem.chain.joints],
        **{kind.replace("-", "_"): name_answer_variable(slot, kind) for kind in parts},
    }  # fmt: skip
    names = [part.name for part in problem.parts]
    relations = sorted(_find_relations(problem), key=lambda pair: names.index(pair[0]))
    return [
        _Check(
            f"{number}.{names.index(name) + 1}", slot, relation,
            relation.left_code.format(**placeholders), relation.right_code.format(**placeholders),
        )
        for name, relation in relations
    ]  # fmt: skip


def _list_compared_numbers(problems: Problems) -> set[str]:
    """Return the numbers of the questions whose answers occur in a check."""
    numbers = set()
    for number, (_, problem) in enumerate(problems, 1):
        compared_kinds = {kind for _, relation in _find_relations(problem) for kind in relation.questions}
        numbers |= {f"{number}.{i}" for i, part in enumerate(problem.parts, 1) if part.kind in compared_kinds}
    return numbers


def _list_symbols(problems: Problems) -> list[tuple[str, list[tuple[str, list[str]]], list[tuple[str, str]]]]:
    """Return, for each slot with checks, the names of symbols by role, and the given values as code."""
    checked_problems = []
    for slot, problem in problems:
        if any(_find_relations(problem)):
            names_by_role: dict[str, list[str]] = {"joint": [], "rate": [], "velocity": [], "load": []}
            for name, info in problem.symbols.items():
                role = "load" if info.role in ("force", "moment") else info.role
                names_by_role.setdefault(role, []).append(name)
            infos = problem.symbols.items()
            given_values = [(name, print_python(info.value)) for name, info in infos if info.value is not None]
            checked_problems.append((slot, list(names_by_role.items()), given_values))
    return checked_problems
