"""Position, velocity and Jacobian by direct differentiation (6.1 to 6.4; Examples 6.1 and 6.3)."""

from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.answers import Expression, Matrix
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Change, Working
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, OneOfSeveral, Part
from qdot.exercises.questions.base import (
    Asked,
    Question,
    number,
    objection_to_length,
    objection_unless_square,
    rates_to,
    stage,
    substitute_number,
    substitute_stage,
    velocities,
)


def moving_rows(chain: Chain) -> list[int]:
    """Return the rows of x, y, z in which the task lets the point move."""
    return ["xyz".index(axis) for axis in chain.linear_rows]


@dataclass(frozen=True, kw_only=True)
class ForTask(Details):
    """About the Jacobian for a task, which need not be the arm's own."""

    task: tuple[str, ...]


def power_of_metres(part: Part) -> int | None:
    """Return the power of metres that a determinant is in, one for each row of linear velocity; None of others."""
    return sum(row.startswith("v") for row in part.about(ForTask).task) if part.kind == "determinant" else None


@dataclass(frozen=True, kw_only=True)
class AlongAxes(Details):
    """About the coordinates of the point that the task counts, some of "x", "y", "z".

    Of a velocity that is written link by link, `by_links` is true.
    """

    axes: tuple[str, ...]
    by_links: bool = False


@dataclass(frozen=True, kw_only=True)
class AlongAxis(OneOfSeveral):
    """About one component of the velocity of the point: its axis, and the row (0 to 2) that it is in."""

    axis: str
    row: int


def _ask_position(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).position.extract(moving_rows(chain), [0])), AlongAxes(axes=chain.linear_rows)


def linear_velocity(chain: Chain) -> sp.Matrix:
    """Return the velocity of the point, the coordinates that the task counts (6.2).

    Where every term of the position has the sine or cosine of one angle, it is written link by link as in Example 6.1,
    -a1 s1 qd1 - a2 s12 (qd1 + qd2); else joint by joint, as J qd.
    """
    d = derive(chain)
    if is_by_links(chain):
        position = d.position.extract(moving_rows(chain), [0])
        return position.applyfunc(lambda entry: _velocity_by_links(entry, chain))
    return d.geometric.extract(moving_rows(chain), list(range(chain.n))) * sp.Matrix(chain.rates)


def is_by_links(chain: Chain) -> bool:
    """Tell whether every term of the position turns by one angle, and one of them by a sum of joint angles."""
    position = derive(chain).position.extract(moving_rows(chain), [0])
    turning = [term.atoms(sp.sin, sp.cos) for entry in position for term in sp.Add.make_args(sp.expand(entry))]
    sums = any(len(trig.args[0].free_symbols) > 1 for trigs in turning for trig in trigs)
    return sums and all(len(trigs) <= 1 for trigs in turning)


def _velocity_by_links(coordinate: sp.Expr, chain: Chain) -> sp.Expr:
    """Return the rate of change of a coordinate; what turns by the same angle has the same sum of joint rates."""
    rates = dict(zip(chain.q, chain.rates, strict=True))
    turning: dict[sp.Expr, sp.Expr] = {}
    for term in sp.Add.make_args(sp.expand(coordinate)):
        angle = next((trig.args[0] for trig in term.atoms(sp.sin, sp.cos)), sp.S.Zero)
        turning[angle] = turning.get(angle, sp.S.Zero) + term
    velocity = sp.S.Zero
    for angle, group in turning.items():
        sliding = [q for q in chain.q if group.has(q) and q not in angle.free_symbols]
        velocity += sp.Add(*(group.diff(q) * rates[q] for q in sliding))
        turned = [q for q in chain.q if q in angle.free_symbols]
        if turned:
            velocity += (
                group.diff(turned[0]) / angle.diff(turned[0]) * sp.Add(*(angle.diff(q) * rates[q] for q in turned))
            )
    return velocity


def _ask_velocity(chain: Chain, rng: Stream) -> Asked:
    by_links = is_by_links(chain)
    return Matrix(linear_velocity(chain)), AlongAxes(axes=chain.linear_rows, by_links=by_links)


def _ask_component(chain: Chain, rng: Stream) -> Asked:
    velocity = linear_velocity(chain)
    useful = [i for i, entry in enumerate(velocity) if len(entry.free_symbols & set(chain.rates)) > 1]
    chosen = rng.choice(useful or list(range(len(velocity))))
    details = AlongAxis(axis=chain.linear_rows[chosen], row=moving_rows(chain)[chosen])
    return Expression(velocity[chosen]), details


def _object_to_task(chain: Chain) -> str | None:
    return None if chain.linear_rows else "its task counts no linear velocity"


def _ask_jacobian(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).jacobian), ForTask(task=chain.task)


def _title(chain: Chain) -> str:
    by_axes = all(row[0] == "w" for row in chain.task)
    return "Jacobian from the joint axes" if by_axes else "Jacobian by differentiation"


def _ask_determinant(chain: Chain, rng: Stream) -> Asked:
    return Expression(derive(chain).determinant), ForTask(task=chain.task)


# --- out of a derivation ---


def _derived_component(w: Working, part: Part) -> np.ndarray:
    return np.asarray(apply_matrix(w["linear"][[part.about(AlongAxis).row]], w["joint rates"]))


def _substitute_position(rows: np.ndarray) -> dict[str, Change]:
    """Differentiate a position, (rows, 1, …), with respect to each joint variable."""

    def differentiate(w: Working, right: np.ndarray) -> np.ndarray:
        slopes, linear = w.arithmetic.slopes(rows[:, 0]), right.copy()
        for k, row in enumerate(moving_rows(w.chain)):
            linear[row] = slopes[:, k]
        return linear

    return {"linear": differentiate}


QUESTIONS = (
    Question(
        name="position",
        title="Position of the point",
        source="6.1",
        ask=_ask_position,
        objection=_object_to_task,
        too_long=objection_to_length("position"),
        result=lambda w, _: w["point"][moving_rows(w.chain)],
        entry_names=lambda chain, _: list(chain.linear_rows),
        labels=lambda chain: tuple(chain.linear_rows),
        substitutes=_substitute_position,
        adds_up="links",
        linear_rows=lambda chain: list(enumerate(moving_rows(chain))),
    ),
    Question(
        name="velocity",
        title="Cartesian velocity",
        source="6.2",
        ask=_ask_velocity,
        needs=("position",),
        objection=_object_to_task,
        too_long=objection_to_length("linear"),
        result=lambda w, _: apply_matrix(w["linear"][moving_rows(w.chain)], w["joint rates"]),
        entry_names=lambda chain, _: velocities([row for row in chain.task if row[0] == "v"]),
        labels=lambda chain: tuple(row for row in chain.task if row[0] == "v"),
        follows=(("position",),),
    ),
    Question(
        name="velocity-component",
        title="One velocity component",
        source="6.2",
        ask=_ask_component,
        needs=("position",),
        objection=_object_to_task,
        too_long=objection_to_length("linear"),
        result=_derived_component,
        entry_names=lambda chain, part: [f"v_{{{part.about(AlongAxis).axis}}}"],
        follows=(("position",),),
    ),
    Question(
        name="jacobian",
        title="Jacobian by differentiation",
        title_for=_title,
        source="6.3",
        ask=_ask_jacobian,
        needs=("position",),
        points=2.0,
        too_long=objection_to_length("jacobian"),
        result=stage("jacobian"),
        grid=rates_to(lambda chain: chain.task),
        substitutes=substitute_stage("jacobian"),
        follows=(("position",),),
        adds_up="columns of links",
        linear_rows=lambda chain: [(k, "xyz".index(row[1])) for k, row in enumerate(chain.task) if row[0] == "v"],
    ),
    Question(
        name="determinant",
        title="Determinant of the Jacobian",
        source="6.8",
        ask=_ask_determinant,
        needs=("jacobian",),
        objection=objection_unless_square,
        result=number("determinant"),
        entry_names=lambda chain, _: [r"\det J"],
        is_made_of_jacobian=True,
        is_made_of_minors=True,
        substitutes=substitute_number("determinant"),
        follows=(("jacobian",),),
    ),
)  # fmt: skip
