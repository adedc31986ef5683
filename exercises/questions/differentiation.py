"""Position, velocity and Jacobian by direct differentiation (6.1 to 6.4; Examples 6.1 and 6.3)."""

import sympy as sp

from exercises.answers import Expression, Matrix
from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.questions.base import Asked, Question, by_hand, square
from exercises.stream import Stream


def moving_rows(chain: Chain) -> list[int]:
    """Return the rows of x, y, z in which the task lets the point move."""
    return ["xyz".index(axis) for axis in chain.linear_rows]


def _position(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).position.extract(moving_rows(chain), [0])), {"axes": chain.linear_rows}


def linear_velocity(chain: Chain) -> sp.Matrix:
    """Return the velocity of the point, the coordinates that the task counts, as J qd (6.2)."""
    found = derive(chain)
    return found.geometric.extract(moving_rows(chain), list(range(chain.n))) * sp.Matrix(chain.rates)


def _velocity(chain: Chain, rng: Stream) -> Asked:
    return Matrix(linear_velocity(chain)), {"axes": chain.linear_rows}


def _component(chain: Chain, rng: Stream) -> Asked:
    velocity = linear_velocity(chain)
    useful = [i for i, entry in enumerate(velocity) if len(entry.free_symbols & set(chain.rates)) > 1]
    chosen = rng.choice(useful or list(range(len(velocity))))
    return Expression(velocity[chosen]), {"axis": chain.linear_rows[chosen], "row": moving_rows(chain)[chosen]}


def _has_linear_rows(chain: Chain) -> str | None:
    return None if chain.linear_rows else "its task counts no linear velocity"


def _jacobian(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).jacobian), {"task": chain.task}


def _determinant(chain: Chain, rng: Stream) -> Asked:
    return Expression(derive(chain).determinant), {"task": chain.task}


QUESTIONS = (
    Question(
        "position", "Position of the point", "6.1", _position, (), 1.0,
        _has_linear_rows, by_hand("position"),
    ),
    Question(
        "velocity", "Cartesian velocity", "6.2", _velocity, ("position",), 1.0, _has_linear_rows, by_hand("linear")
    ),
    Question(
        "velocity-component", "One velocity component", "6.2", _component, ("position",), 1.0,
        _has_linear_rows, by_hand("linear"),
    ),
    Question(
        "jacobian", "Jacobian by differentiation", "6.3", _jacobian, ("position",), 2.0, too_long=by_hand("jacobian")
    ),
    Question("determinant", "Determinant of the Jacobian", "6.8", _determinant, ("jacobian",), 1.0, square),
)  # fmt: skip
