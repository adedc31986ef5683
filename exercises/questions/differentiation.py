"""Position, velocity and Jacobian by direct differentiation (6.1 to 6.4; Examples 6.1 and 6.3)."""

from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import Change, StageResults
from qdot.exercises.problem.problem import Details, Part, ResultChoiceDetails, recorded_as
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question
from qdot.exercises.reference_answers import Expression


def list_linear_task_rows(chain: Chain) -> list[int]:
    """Return the indices (0 to 2) of the coordinates x, y, z whose velocities are in the task."""
    return ["xyz".index(axis) for axis in chain.linear_axes]


@dataclass(frozen=True, kw_only=True)
class TaskDetails(Details):
    """Details of a question about the Jacobian for a task, which may differ from the arm's usual task."""

    task: tuple[str, ...]


def find_determinant_power_of_metres(chain: Chain, part: Part) -> int | None:
    """Return k for the unit m^k of a determinant: the number of linear rows minus the number of prismatic joints.

    Return None for parts that do not ask for a determinant.
    """
    if part.kind != "determinant":
        return None
    return sum(row[0] == "v" for row in part.details_as(TaskDetails).task) - len(chain.prismatic_joints)


@dataclass(frozen=True, kw_only=True)
class AxesDetails(Details):
    """Details of a question about coordinates of P; `axes` are the names of the coordinates: "x", "y", "z".

    `is_written_by_links` says whether the velocities are written link by link, as in Example 6.1.
    """

    axes: tuple[str, ...]
    is_written_by_links: bool = field(default=False, metadata=recorded_as("by_links"))


@dataclass(frozen=True, kw_only=True)
class AxisDetails(ResultChoiceDetails):
    """Details of a question about one component of the velocity of P: its axis ("x", "y" or "z") and row (0 to 2)."""

    axis: str
    row: int


def write_linear_velocity(chain: Chain) -> sp.Matrix:
    """Return the components of the velocity of P that are in the task, as a column (6.2).

    If every term of the position has the sine or cosine of at most one angle, and at least one angle is a sum, the
    velocity is written link by link, as in Example 6.1: -a1 s1 qd1 - a2 s12 (qd1 + qd2). Otherwise it is written joint
    by joint, as J qd.
    """
    derivation, rows = derive(chain), list_linear_task_rows(chain)
    if _is_written_by_links(chain):
        return derivation.position.extract(rows, [0]).applyfunc(lambda entry: _differentiate_by_links(entry, chain))
    return derivation.geometric_jacobian.extract(rows, list(range(chain.n))) * sp.Matrix(chain.rates)


def _is_written_by_links(chain: Chain) -> bool:
    """Return whether each term of the position depends on at most one angle, and at least one angle is a sum."""
    position = derive(chain).position.extract(list_linear_task_rows(chain), [0])
    trigs_of_terms = [term.atoms(sp.sin, sp.cos) for entry in position for term in sp.Add.make_args(sp.expand(entry))]
    has_angle_sum = any(len(trig.args[0].free_symbols) > 1 for trigs in trigs_of_terms for trig in trigs)
    return has_angle_sum and all(len(trigs) <= 1 for trigs in trigs_of_terms)


def _differentiate_by_links(coordinate: sp.Expr, chain: Chain) -> sp.Expr:
    """Return the rate of change of a coordinate, in which terms with the same angle have the same sum of rates."""
    rates = dict(zip(chain.q, chain.rates, strict=True))
    terms_by_angle: dict[sp.Expr, sp.Expr] = {}
    for term in sp.Add.make_args(sp.expand(coordinate)):
        angle = next((trig.args[0] for trig in term.atoms(sp.sin, sp.cos)), sp.S.Zero)
        terms_by_angle[angle] = terms_by_angle.get(angle, sp.S.Zero) + term
    velocity = sp.S.Zero
    for angle, term_sum in terms_by_angle.items():
        prismatic_variables = [q for q in chain.q if term_sum.has(q) and q not in angle.free_symbols]
        velocity += sp.Add(*(term_sum.diff(q) * rates[q] for q in prismatic_variables))
        angle_variables = [q for q in chain.q if q in angle.free_symbols]
        if angle_variables:
            angle_rate = sp.Add(*(angle.diff(q) * rates[q] for q in angle_variables))
            velocity += term_sum.diff(angle_variables[0]) / angle.diff(angle_variables[0]) * angle_rate
    return velocity


def _choose_component(chain: Chain, rng: Stream) -> AxisDetails:
    velocity = write_linear_velocity(chain)
    rows_with_several_rates = [i for i, entry in enumerate(velocity) if len(entry.free_symbols & set(chain.rates)) > 1]
    index = rng.choice(rows_with_several_rates or list(range(len(velocity))))
    return AxisDetails(axis=chain.linear_axes[index], row=list_linear_task_rows(chain)[index])


def _find_task_objection(chain: Chain) -> str | None:
    return None if chain.linear_axes else "its task has no linear velocity"


def _substitute_position(position: np.ndarray) -> dict[str, Change]:
    """Return the changes that replace the point and the linear rows by those that follow from a student's position.

    `position` includes its derivatives; the shape is (rows, 1, …).
    """

    def move_point(stages: StageResults, correct: np.ndarray) -> np.ndarray:
        point = correct.copy()
        point[list_linear_task_rows(stages.chain)] = stages.arithmetic.drop_derivatives(position[:, 0])
        return point

    def differentiate(stages: StageResults, correct: np.ndarray) -> np.ndarray:
        derivatives, linear_rows = stages.arithmetic.compute_derivatives(position[:, 0]), correct.copy()
        for k, row in enumerate(list_linear_task_rows(stages.chain)):
            linear_rows[row] = derivatives[:, k]
        return linear_rows

    return {"point": move_point, "linear rows": differentiate}


QUESTIONS = (
    Question(
        "position", "Position of the point", "6.1",
        formula="p", substitution=_substitute_position, differentiates_substitute=True,
        make_details=lambda chain, _: AxesDetails(axes=chain.linear_axes),
        name_entries=lambda chain, _: chain.linear_axes, find_arm_objection=_find_task_objection,
        find_size_objection=base.limit_terms("position"), link_sums="links",
        find_link_sum_rows=lambda chain: list(enumerate(list_linear_task_rows(chain))),
    ),
    Question(
        "velocity", "Cartesian velocity", "6.2", prerequisites=("position",),
        formula="v", derive_matrix=lambda chain, _: write_linear_velocity(chain),
        make_details=lambda chain, _: AxesDetails(
            axes=chain.linear_axes, is_written_by_links=_is_written_by_links(chain)
        ),
        name_entries=lambda chain, _: base.name_velocity_components([row for row in chain.task if row[0] == "v"]),
        find_arm_objection=_find_task_objection, find_size_objection=base.limit_terms("linear_rows"),
    ),
    Question(
        "velocity-component", "One velocity component", "6.2", prerequisites=("position",),
        formula="v", answer_type=Expression, make_details=_choose_component,
        derive_matrix=lambda chain, details: write_linear_velocity(chain)[chain.linear_axes.index(details.axis), :],
        name_entries=lambda chain, details: [f"v_{{{details.axis}}}"],
        find_arm_objection=_find_task_objection, find_size_objection=base.limit_terms("linear_rows"),
    ),
    Question(
        "jacobian", "Jacobian by differentiation", "6.3", prerequisites=("position",), points=2.0,
        choose_title=lambda chain: (
            "Jacobian by differentiation" if chain.linear_axes else "Jacobian from the joint axes"
        ),
        formula="J", make_details=lambda chain, _: TaskDetails(task=chain.task),
        label_rows_and_columns=base.label_jacobian(lambda chain: chain.task),
        find_size_objection=base.limit_terms("jacobian"), link_sums="columns of links",
        find_link_sum_rows=lambda chain: [
            (k, "xyz".index(row[1])) for k, row in enumerate(chain.task) if row[0] == "v"
        ],
    ),
    Question(
        "determinant", "Determinant of the Jacobian", "6.8", prerequisites=("jacobian",),
        formula="det(J)", answer_type=Expression, make_details=lambda chain, _: TaskDetails(task=chain.task),
        name_entries=lambda chain, _: [r"\det J"], find_arm_objection=base.find_determinant_objection,
        is_made_of_jacobian=True, is_made_of_minors=True,
    ),
)  # fmt: skip
