"""Write cells with which students check their answers against each other, without access to the correct answers.

The table `RELATIONS` has equations between answers, in Python code for the cell that a student runs. The function that
the cell calls (`templates/notebook/self-check.py.j2`) is in the notebook and needs only SymPy and NumPy.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

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


@dataclass(frozen=True)
class Relation:
    """An equation between answers to several questions: Python code for its left and its right side.

    In the code, `{position}` stands for the answer on position. `at` is a random configuration: `at(answer)` are the
    values of an answer there, and `at.slope(answer)` its derivatives with respect to the joint variables. `needs` are
    the questions whose answers occur, and `question` is what the check prints. `applies` says whether the equation
    applies to an arm. `is_singular_set` means that the left side is a singular set, which is checked against a
    Jacobian.
    """

    needs: tuple[str, ...]
    question: str
    left_code: str
    right_code: str
    applies: Callable[[Chain, PartsByKind], bool] = lambda _, __: True
    is_singular_set: bool = False


def _coordinate_indices(parts: PartsByKind, name: str = "position") -> list[int]:
    """Return the indices of the coordinates x, y, z that a question asks for."""
    return ["xyz".index(axis) for axis in getattr(parts[name].details, "axes", "xyz")]


def _has_linear_rows_first(chain: Chain, _: PartsByKind) -> bool:
    return len(chain.linear_rows) > 0 and [row[0] for row in chain.task] == sorted(row[0] for row in chain.task)


def _has_all_task_rows(chain: Chain, parts: PartsByKind) -> bool:
    return getattr(parts["jacobian"].details, "task", chain.task) == chain.task


def _is_square(chain: Chain, _: PartsByKind) -> bool:
    return len(chain.task) == chain.n


def _is_all_revolute(chain: Chain, _: PartsByKind) -> bool:
    return all(joint.kind == "R" for joint in chain.joints) and chain.point.frame == chain.n


def _is_point_last_origin(chain: Chain, _: PartsByKind) -> bool:
    point = convention_of(chain).point
    return point.frame == chain.n and point.is_origin


RELATIONS = (
    Relation(
        ("transform",), "Are the columns of your rotation unit vectors at right angles?",
        "at({transform})[:3, :3].T @ at({transform})[:3, :3]", "np.eye(3)",
    ),
    Relation(
        ("transform", "position"), "Is your position the last column of your transform?",
        "at({position}).reshape(-1)", "at({transform})[{rows}, 3]", _is_point_last_origin,
    ),
    Relation(
        ("position", "velocity"), "Is your velocity the derivative of your position?",
        "at({velocity})", "at.slope({position}) @ at.rates",
    ),
    Relation(
        ("position", "jacobian"), "Is your Jacobian the derivative of your position?",
        "at({jacobian})[:{linear}]", "at.slope({position})",
        lambda chain, asked: _has_linear_rows_first(chain, asked)
        and len(_coordinate_indices(asked)) == len(chain.linear_rows),
    ),
    Relation(
        ("joint-axes",), "Are your joint axes unit vectors?",
        "(at({joint_axes}) ** 2).sum(axis=0)", "np.ones({n})",
    ),
    Relation(
        ("joint-axes", "position-vectors", "geometric-jacobian"),
        "Are the linear rows of your geometric Jacobian your axes times your vectors?",
        "at({geometric_jacobian})[{linear_half}]", "np.cross(at({joint_axes}), at({position_vectors}), axis=0)",
        _is_all_revolute,
    ),
    Relation(
        ("joint-axes", "geometric-jacobian"),
        "Are the angular rows of your geometric Jacobian your axes, for joints that turn?",
        "at({geometric_jacobian})[{angular_half}]", "at({joint_axes}) * {turning}",
    ),
    Relation(
        ("position", "geometric-jacobian"), "Are its linear rows the derivative of your position?",
        "at({geometric_jacobian})[{linear_half}][{rows}]", "at.slope({position})",
    ),
    Relation(
        ("transform", "geometric-jacobian"), "Is your geometric Jacobian how your transform moves?",
        "at({geometric_jacobian})", "at.motion({transform})", _is_point_last_origin,
    ),
    Relation(
        ("transform", "geometric-jacobian"), "Do its angular rows say how your transform turns?",
        "at({geometric_jacobian})[{angular_half}]", "at.motion({transform})[3:]",
        lambda chain, asked: not _is_point_last_origin(chain, asked),
    ),
    Relation(
        ("geometric-jacobian", "twist"), "Is your twist your geometric Jacobian times the joint rates?",
        "at({twist})", "at({geometric_jacobian}) @ at.rates",
    ),
    Relation(
        ("transform", "geometric-jacobian", "tool-jacobian"),
        "Is your Jacobian in the tool frame the geometric one, turned by your rotation?",
        "at({tool_jacobian})", "at.into_tool({transform}) @ at({geometric_jacobian})",
    ),
    Relation(
        ("body-pose",), "Are the columns of the rotation in your pose unit vectors at right angles?",
        "at({body_pose})[:3, :3].T @ at({body_pose})[:3, :3]", "np.eye(3)",
    ),
    Relation(
        ("body-pose", "position"), "Is your position the last column of your pose?",
        "at({position}).reshape(-1)", "at({body_pose})[{rows}, 3]",
    ),
    Relation(
        ("body-pose", "body-adjoint"), "Are the columns of your adjoint for the angular velocity made of your pose?",
        "at({body_adjoint})[:, {angular_half}]",
        "np.vstack([at({body_pose})[:3, :3], "
        "np.cross(at({body_pose})[:3, 3:], at({body_pose})[:3, :3], axis=0)]){in_order}",
    ),
    Relation(
        ("home-screws", "space-jacobian"), "Is the first column of your space Jacobian your first screw?",
        "at({space_jacobian})[:, 0]", "at({home_screws})[:, 0]",
    ),
    Relation(
        ("body-pose", "space-jacobian"), "Is your space Jacobian how your pose moves?",
        "at({space_jacobian})",
        "np.vstack([at.motion({body_pose})[3:], at.motion({body_pose})[:3] "
        "+ np.cross(at({body_pose})[:3, 3:], at.motion({body_pose})[3:], axis=0)]){in_order}",
    ),
    Relation(
        ("body-pose", "body-jacobian"), "Is your body Jacobian how your pose moves, in its own axes?",
        "at({body_jacobian})", "at.into_tool({body_pose}) @ np.roll(at.motion({body_pose}), 3, axis=0){in_order}",
    ),
    Relation(
        ("body-adjoint", "space-jacobian", "body-jacobian"),
        "Does your adjoint change your body Jacobian into your space Jacobian?",
        "at({body_adjoint}) @ at({body_jacobian})", "at({space_jacobian})",
    ),
    Relation(
        ("space-jacobian", "space-twist"), "Is your space twist your space Jacobian times the joint rates?",
        "at({space_twist})", "at({space_jacobian}) @ at.rates",
    ),
    Relation(
        ("body-jacobian", "body-twist"), "Is your body twist your body Jacobian times the joint rates?",
        "at({body_twist})", "at({body_jacobian}) @ at.rates",
    ),
    Relation(
        ("jacobian", "determinant"), "Is your determinant that of your Jacobian?",
        "at({determinant})", "np.linalg.det(np.atleast_2d(at({jacobian})))",
        lambda chain, asked: _is_square(chain, asked) and _has_all_task_rows(chain, asked),
    ),
    Relation(
        ("jacobian", "gram-determinant"), "Is your determinant that of J times its transpose?",
        "at({gram_determinant})", "np.linalg.det(at({jacobian}) @ at({jacobian}).T)", _has_all_task_rows,
    ),
    Relation(
        ("jacobian", "inverse-jacobian"), "Do your Jacobian and its inverse make the identity?",
        "at({jacobian}) @ at({inverse_jacobian})", "np.eye({n})", _is_square,
    ),
    Relation(
        ("jacobian", "inverse-velocity"), "Do your joint rates give the velocity that was asked?",
        "at({jacobian}) @ at({inverse_velocity})", "at.velocity", _is_square,
    ),
    Relation(
        ("jacobian", "joint-torques"), "Are your torques the transpose of J times the load?",
        "at({joint_torques})", "np.atleast_2d(at({jacobian})).T @ at.load",
    ),
    Relation(
        ("jacobian", "singular-angles"), "Are these the singular configurations of your Jacobian?",
        "{singular_angles}", "{jacobian}", is_singular_set=True,
    ),
)  # fmt: skip
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
    placeholders: dict[str, object] = {
        kind.replace("-", "_"): answer_variable(slot, part_of_kind.name) for kind, part_of_kind in parts.items()
    }
    placeholders |= {
        "linear_half": "3:" if omega_first else ":3",
        "angular_half": ":3" if omega_first else "3:",
        "in_order": "" if omega_first else "[np.r_[3:6, 0:3]]",
        "n": problem.chain.n,
        "linear": len(problem.chain.linear_rows),
        "rows": _coordinate_indices(parts) if "position" in parts else [],
        "turning": [int(joint.kind == "R") for joint in problem.chain.joints],
    }
    checks = [
        replace(
            relation,
            left_code=relation.left_code.format(**placeholders),
            right_code=relation.right_code.format(**placeholders),
        )
        for relation in relations
    ]
    return render("notebook/check.py.j2", slot=slot, checks=checks).strip()


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
