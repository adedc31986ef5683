"""Position, velocity and Jacobian by direct differentiation (6.1 to 6.4; Examples 6.1 and 6.3)."""

from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Expression
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Change, Working
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, Part, ResultChoiceDetails
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question


def list_linear_task_rows(chain: Chain) -> list[int]:
    """Return the indices of the coordinates x, y, z whose velocity is in the task."""
    return ["xyz".index(axis) for axis in chain.linear_axes]


@dataclass(frozen=True, kw_only=True)
class TaskDetails(Details):
    """Details of a question about the Jacobian for a task, which may differ from the arm's own."""

    task: tuple[str, ...]


def find_power_of_metres(part: Part) -> int | None:
    """Return the power of metres in a determinant's unit, one per linear row of the task; None for other parts."""
    return sum(row.startswith("v") for row in part.details_as(TaskDetails).task) if part.kind == "determinant" else None


@dataclass(frozen=True, kw_only=True)
class AxesDetails(Details):
    """Details of a question about the coordinates of the tool point whose velocity is in the task, from "x", "y", "z".

    `by_links` says whether a velocity is written link by link, as in Example 6.1.
    """

    axes: tuple[str, ...]
    by_links: bool = False


@dataclass(frozen=True, kw_only=True)
class AxisDetails(ResultChoiceDetails):
    """Details of a question about one component of the tool point's velocity: its axis and its row (0 to 2)."""

    axis: str
    row: int


def write_linear_velocity(chain: Chain) -> sp.Matrix:
    """Return the components of the tool point's velocity that are in the task (6.2).

    If every term of the position has the sine or cosine of at most one angle, the velocity is written link by link, as
    in Example 6.1: -a1 s1 qd1 - a2 s12 (qd1 + qd2). Otherwise it is written joint by joint, as J qd.
    """
    d = derive(chain)
    if is_written_by_links(chain):
        position = d.position.extract(list_linear_task_rows(chain), [0])
        return position.applyfunc(lambda entry: _differentiate_by_links(entry, chain))
    return d.geometric.extract(list_linear_task_rows(chain), list(range(chain.n))) * sp.Matrix(chain.rates)


def is_written_by_links(chain: Chain) -> bool:
    """Return whether each term of the position depends on at most one angle, and one of these is a sum of angles."""
    position = derive(chain).position.extract(list_linear_task_rows(chain), [0])
    trig_terms = [term.atoms(sp.sin, sp.cos) for entry in position for term in sp.Add.make_args(sp.expand(entry))]
    has_angle_sum = any(len(trig.args[0].free_symbols) > 1 for trigs in trig_terms for trig in trigs)
    return has_angle_sum and all(len(trigs) <= 1 for trigs in trig_terms)


def _differentiate_by_links(coordinate: sp.Expr, chain: Chain) -> sp.Expr:
    """Return the rate of change of a coordinate; terms of the same angle share one sum of joint rates."""
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
    multi_rate_rows = [i for i, entry in enumerate(velocity) if len(entry.free_symbols & set(chain.rates)) > 1]
    index = rng.choice(multi_rate_rows or list(range(len(velocity))))
    return AxisDetails(axis=chain.linear_axes[index], row=list_linear_task_rows(chain)[index])


def _write_component(chain: Chain, details: Details) -> sp.Matrix:
    assert isinstance(details, AxisDetails)
    return write_linear_velocity(chain)[chain.linear_axes.index(details.axis), :]


def _derive_component(w: Working, details: Details) -> np.ndarray:
    assert isinstance(details, AxisDetails)
    return apply_matrix(w["linear"][[details.row]], w["joint rates"])


def _object_to_task(chain: Chain) -> str | None:
    return None if chain.linear_axes else "its task has no linear velocity"


def _choose_title(chain: Chain) -> str:
    by_axes = all(row[0] == "w" for row in chain.task)
    return "Jacobian from the joint axes" if by_axes else "Jacobian by differentiation"


def _substitute_position(position: np.ndarray) -> dict[str, Change]:
    """Return the change that replaces the linear Jacobian by the derivatives of a position, (rows, 1, …)."""

    def differentiate(w: Working, correct: np.ndarray) -> np.ndarray:
        derivatives, linear = w.arithmetic.derivatives(position[:, 0]), correct.copy()
        for k, row in enumerate(list_linear_task_rows(w.chain)):
            linear[row] = derivatives[:, k]
        return linear

    return {"linear": differentiate}


QUESTIONS = (
    Question(
        "position", "Position of the point", "6.1", formula=lambda w, _: w["point"][list_linear_task_rows(w.chain)],
        substitution=_substitute_position, make_details=lambda chain, _: AxesDetails(axes=chain.linear_axes),
        entry_names=lambda chain, _: chain.linear_axes, objection=_object_to_task,
        too_long=base.make_length_objection("position"), link_sums="links",
        link_sum_rows=lambda chain: list(enumerate(list_linear_task_rows(chain))),
    ),
    Question(
        "velocity", "Cartesian velocity", "6.2", needs=("position",),
        formula=lambda w, _: apply_matrix(w["linear"][list_linear_task_rows(w.chain)], w["joint rates"]),
        reference=lambda chain, _: write_linear_velocity(chain),
        make_details=lambda chain, _: AxesDetails(axes=chain.linear_axes, by_links=is_written_by_links(chain)),
        entry_names=lambda chain, _: base.name_velocity_components([row for row in chain.task if row[0] == "v"]),
        objection=_object_to_task, too_long=base.make_length_objection("linear"),
    ),
    Question(
        "velocity-component", "One velocity component", "6.2", needs=("position",),
        formula=_derive_component, reference=_write_component, answer_type=Expression, make_details=_choose_component,
        entry_names=lambda chain, part: [f"v_{{{part.details_as(AxisDetails).axis}}}"],
        objection=_object_to_task, too_long=base.make_length_objection("linear"),
    ),
    Question(
        "jacobian", "Jacobian by differentiation", "6.3", needs=("position",), points=2.0, title_for=_choose_title,
        stage="jacobian", make_details=lambda chain, _: TaskDetails(task=chain.task),
        row_and_column_labels=base.make_jacobian_labels(lambda chain: chain.task),
        too_long=base.make_length_objection("jacobian"), link_sums="columns of links",
        link_sum_rows=lambda chain: [(k, "xyz".index(row[1])) for k, row in enumerate(chain.task) if row[0] == "v"],
    ),
    Question(
        "determinant", "Determinant of the Jacobian", "6.8", needs=("jacobian",),
        stage="determinant", answer_type=Expression, make_details=lambda chain, _: TaskDetails(task=chain.task),
        entry_names=lambda chain, _: [r"\det J"], objection=base.object_unless_square,
        is_made_of_jacobian=True, is_made_of_minors=True,
    ),
)  # fmt: skip
