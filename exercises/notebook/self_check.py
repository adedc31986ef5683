"""Write notebook cells with which students check their answers against each other, without the correct answers.

The file relations.toml has the equations between answers, as Python code for the cell that a student runs. The cell
calls a function that another cell of the notebook defines (`templates/notebook/self-check.py.j2`). That function needs
only SymPy and NumPy.
"""

import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.writing.render import render

SELF_CHECK = "self_check"
"""The prefix of all names that the cells with checks define."""

Problems = Sequence[tuple[str, Problem]]
"""The problems of a notebook, each with its slot: p1, p2, …"""
PartsByKind = dict[str, Part]
"""The parts of a problem by the names of their questions."""


def _list_coordinate_indices(parts: PartsByKind) -> list[int]:
    """Return the indices (from 0) of the coordinates x, y, z for which the question on position asks."""
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
"""The conditions under which a relation applies to an arm and its questions, by name."""


@dataclass(frozen=True)
class Relation:
    """An equation between the answers to several questions.

    - `questions` are the questions whose answers occur in the equation.
    - `printed_question` is what the check prints, such as "Is your velocity the derivative of your position?"
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


def write_check_cell(slot: str, problem: Problem, part: str) -> str:
    """Return the cell with the checks that become possible with an answer to a part, or "" if there are none."""
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
    checks = [
        (relation, relation.left_code.format(**placeholders), relation.right_code.format(**placeholders))
        for name, relation in _find_relations(problem)
        if name == part
    ]
    return render("notebook/check.py.j2", slot=slot, checks=checks).strip() if checks else ""


def write_function_cell(problems: Problems) -> str:
    """Return the cell with the function that the checks call, or "" if no problem has any checks."""
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
    return render("notebook/self-check.py.j2", problems=checked_problems).strip() if checked_problems else ""


def write_self_check_cells(problems: Problems) -> tuple[str, frozenset[str]]:
    """Return the cell with the function, and the set of all cells with checks, as in a notebook with these problems."""
    cells = {write_check_cell(slot, problem, part.name) for slot, problem in problems for part in problem.parts}
    return write_function_cell(problems), frozenset(cells - {""})
