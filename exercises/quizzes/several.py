"""All right options out of five: singular configurations, other ways to write a result, joints on which it depends."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers import Selection
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import Asked, square
from qdot.exercises.quizzes.asking import short_question
from qdot.exercises.quizzes.options import Offered, Options, Places
from qdot.exercises.quizzes.places import drawn_lengths, regular_poses, several, singular_poses, words
from qdot.exercises.quizzes.wrong import LONGEST, Subject, all_differ, wrong_forms

OPTIONS = 5

# --- which of these configurations are singular? ---


def _configurations(chain: Chain, rng: Stream) -> Asked | None:
    for _ in range(4):
        arm, lengths = drawn_lengths(chain, rng)
        many = rng.choice((2, 3))
        right = several(singular_poses(arm, rng), many)
        wrong = several(regular_poses(arm, rng), OPTIONS - len(right), [pose for pose, _ in right])
        if len(right) == many and len(right) + len(wrong) == OPTIONS:
            order = rng.shuffled([*right, *wrong])
            places, blames = (tuple(column) for column in zip(*order, strict=True))
            correct = tuple(index for index, one in enumerate(order) if one in right)
            answer = Selection(tuple(words(pose) for pose in places), correct)
            return answer, Places(places=places, lengths=lengths, blames=blames)
    return None


# --- on which joints does it depend? ---


@dataclass(frozen=True)
class Quantity:
    """A result of the derivation: det J, a row of the position, a column or an entry of the task Jacobian."""

    name: str
    row: int | None = None
    column: int | None = None

    def of(self, chain: Chain) -> sp.Matrix:
        """Return its formulas, a column."""
        d = derive(chain)
        if self.name == "determinant":
            return sp.Matrix([d.determinant])
        if self.name == "position":
            return sp.Matrix([d.position[self.row]])
        column = d.jacobian.col(self.column)
        return column if self.row is None else sp.Matrix([column[self.row]])


@dataclass(frozen=True, kw_only=True)
class OfQuantity(Details):
    """About a result of the derivation."""

    quantity: Quantity


@dataclass(frozen=True, kw_only=True)
class EqualForms(Options):
    """Ways to write a result of the derivation, right and wrong, that are offered."""

    quantity: Quantity


def quantities(chain: Chain) -> list[Quantity]:
    """Return what can be asked about on an arm."""
    asked = [] if square(chain) else [Quantity("determinant")]
    asked += [Quantity("position", "xyz".index(axis)) for axis in chain.linear_rows]
    return asked + [Quantity("column", None, column) for column in range(chain.n)]


def joints_of(chain: Chain, quantity: Quantity) -> tuple[int, ...]:
    """Return the joints, from 0, on whose variables a quantity depends."""
    free = quantity.of(chain).free_symbols
    return tuple(index for index, q in enumerate(chain.q) if q in free)


def _telling(chain: Chain) -> list[Quantity]:
    """Return what depends on some joints, and not on all of them."""
    return [one for one in quantities(chain) if 0 < len(joints_of(chain, one)) < chain.n]


def _dependence(chain: Chain, rng: Stream) -> Asked | None:
    telling = _telling(chain)
    if not telling:
        return None
    quantity = rng.choice(telling)
    return Selection(tuple(q.name for q in chain.q), joints_of(chain, quantity)), OfQuantity(quantity=quantity)


# --- which of these are the same? ---


def _forms(chain: Chain, rng: Stream) -> Asked | None:
    for quantity in rng.shuffled(_short(chain)):
        offered = _five(chain, quantity, rng)
        if offered is not None:
            order = tuple(rng.shuffled(offered))
            correct = tuple(index for index, option in enumerate(order) if not option.behind)
            answer = Selection(tuple(option.text for option in order), correct)
            return answer, EqualForms(offered=order, quantity=quantity)
    return None


def _short(chain: Chain) -> list[Quantity]:
    entries = [Quantity("column", row, column) for row in range(len(chain.task)) for column in range(chain.n)]
    asked = ([] if square(chain) else [Quantity("determinant")]) + entries
    return [one for one in asked if one.of(chain)[0].has(sp.sin, sp.cos) and len(str(one.of(chain)[0])) <= LONGEST]


def _five(chain: Chain, quantity: Quantity, rng: Stream) -> list[Offered] | None:
    """Return two or three ways to write a result and as many wrong ones as make five, None where there are too few."""
    generic = structure(chain).chain
    right = _ways(generic, quantity.of(generic)[0], quantity)
    base = "determinant" if quantity.name == "determinant" else "jacobian"
    subject = Subject(base, *((None, None) if base == "determinant" else (quantity.column, quantity.row)))
    wrong = [(way, blame) for formula, blame in wrong_forms(generic, subject) for way in _ways(generic, formula)]
    if len(right) < 2 or len(wrong) < 3:
        return None
    fill = derive(chain).fill
    many = min(rng.choice((2, 3)), len(right))
    for _ in range(8):
        chosen = [Offered(fill(way)) for way in rng.shuffled(right)[:many]]
        others = [Offered(fill(way), (blame,)) for way, blame in rng.shuffled(wrong)[: OPTIONS - many]]
        texts = {option.text for option in (*chosen, *others)}
        told_apart = all(
            all_differ(chain, [sp.Matrix([chosen[0].shown]), sp.Matrix([other.shown])]) for other in others
        )
        if len(texts) == OPTIONS and told_apart:
            return [*chosen, *others]
    return None


def _ways(generic: Chain, formula: sp.Expr, quantity: Quantity | None = None) -> list[sp.Expr]:
    """Return a formula as it is and with sums of angles taken apart; a determinant also as the products of entries."""
    apart = sp.expand(sp.expand_trig(formula))
    ways = [formula, apart, sp.expand(formula)]
    if quantity is not None and quantity.name == "determinant" and generic.n == 2:
        (a, b), (c, d) = derive(generic).jacobian.tolist()
        ways.append(sp.expand(a * d) - sp.expand(b * c))
    return [way for way in dict.fromkeys(ways) if len(str(way)) <= 2 * LONGEST]


SELECTIONS = (
    short_question(
        "singular-configurations", "Which of these are singular?", "6.8", _configurations, "selection",
        "singular-angles", "it has no five configurations to choose from", ("singular-angles",), points=1.0,
    ),
    short_question(
        "dependence", "On which joints does it depend?", "6.4", _dependence, "selection",
        "jacobian", "what could be asked about depends on all joints, or on none",
        undiagnosed="the letters of joints tell of no way to them",
    ),
    short_question(
        "equal-forms", "Which of these are the same?", "6.4", _forms, "selection",
        "jacobian", "no result of it is short and can be written in several ways", ("jacobian", "determinant"),
        points=1.0,
    ),
)  # fmt: skip
