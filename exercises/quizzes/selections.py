"""Select all right options out of five: singular configurations, forms of a result, joints on which it depends."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers import Selection
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import Asked, objection_unless_square
from qdot.exercises.quizzes.asking import ShortQuestion
from qdot.exercises.quizzes.options import OfferedOption, Options, Places
from qdot.exercises.quizzes.places import regular_poses, singular_poses, take_distinct, with_random_lengths, write_pose
from qdot.exercises.quizzes.wrong import LONGEST, Subject, all_differ, list_wrong_forms

OPTIONS = 5

# --- which of these configurations are singular? ---


def _ask_configurations(chain: Chain, rng: Stream) -> Asked | None:
    for _ in range(4):
        arm, lengths = with_random_lengths(chain, rng)
        many = rng.choice((2, 3))
        right = take_distinct(singular_poses(arm, rng), many)
        wrong = take_distinct(regular_poses(arm, rng), OPTIONS - len(right), [pose for pose, _ in right])
        if len(right) == many and len(right) + len(wrong) == OPTIONS:
            order = rng.permutation([*right, *wrong])
            places, blames = (tuple(column) for column in zip(*order, strict=True))
            correct = tuple(index for index, place_and_blame in enumerate(order) if place_and_blame in right)
            answer = Selection(tuple(write_pose(pose) for pose in places), correct)
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
    """Asks about a result of the derivation."""

    quantity: Quantity


@dataclass(frozen=True, kw_only=True)
class EqualForms(Options):
    """Right and wrong ways to write a result of the derivation."""

    quantity: Quantity


def _list_determinant(chain: Chain) -> list[Quantity]:
    return [] if objection_unless_square(chain) else [Quantity("determinant")]


def quantities(chain: Chain) -> list[Quantity]:
    """Return the results that can be asked about on an arm."""
    coordinates = [Quantity("position", "xyz".index(axis)) for axis in chain.linear_rows]
    return [*_list_determinant(chain), *coordinates, *(Quantity("column", None, column) for column in range(chain.n))]


def joints_of(chain: Chain, quantity: Quantity) -> tuple[int, ...]:
    """Return the joints, from 0, on whose variables a quantity depends."""
    free = quantity.of(chain).free_symbols
    return tuple(index for index, q in enumerate(chain.q) if q in free)


def _ask_dependence(chain: Chain, rng: Stream) -> Asked | None:
    partial_quantities = [quantity for quantity in quantities(chain) if 0 < len(joints_of(chain, quantity)) < chain.n]
    if not partial_quantities:
        return None
    quantity = rng.choice(partial_quantities)
    return Selection(tuple(q.name for q in chain.q), joints_of(chain, quantity)), OfQuantity(quantity=quantity)


# --- which of these are the same? ---


def _ask_forms(chain: Chain, rng: Stream) -> Asked | None:
    for quantity in rng.permutation(_find_short_quantities(chain)):
        offered = _make_five_options(chain, quantity, rng)
        if offered is not None:
            order = tuple(rng.permutation(offered))
            correct = tuple(index for index, option in enumerate(order) if not option.behind)
            answer = Selection(tuple(option.text for option in order), correct)
            return answer, EqualForms(offered=order, quantity=quantity)
    return None


def _find_short_quantities(chain: Chain) -> list[Quantity]:
    def is_short(quantity: Quantity) -> bool:
        formula = quantity.of(chain)[0]
        return bool(formula.has(sp.sin, sp.cos)) and len(str(formula)) <= LONGEST

    entries = [Quantity("column", row, column) for row in range(len(chain.task)) for column in range(chain.n)]
    return [*filter(is_short, [*_list_determinant(chain), *entries])]


def _make_five_options(chain: Chain, quantity: Quantity, rng: Stream) -> list[OfferedOption] | None:
    """Return two or three right ways to write a result, with wrong ones to make five; None if there are too few."""
    generic = structure(chain).chain
    right = _write_ways(generic, quantity.of(generic)[0], quantity)
    base = "determinant" if quantity.name == "determinant" else "jacobian"
    subject = Subject(base, quantity.column, quantity.row)
    wrong = [
        (way, blame) for formula, blame in list_wrong_forms(generic, subject) for way in _write_ways(generic, formula)
    ]
    if len(right) < 2 or len(wrong) < 3:
        return None
    fill = derive(chain).fill
    many = min(rng.choice((2, 3)), len(right))
    for _ in range(8):
        chosen = [OfferedOption(fill(way)) for way in rng.permutation(right)[:many]]
        others = [OfferedOption(fill(way), (blame,)) for way, blame in rng.permutation(wrong)[: OPTIONS - many]]
        texts = {option.text for option in (*chosen, *others)}
        right_one, *wrong_ones = (sp.Matrix([option.shown]) for option in (chosen[0], *others))
        if len(texts) == OPTIONS and all(all_differ(chain, [right_one, wrong_one]) for wrong_one in wrong_ones):
            return [*chosen, *others]
    return None


def _write_ways(generic: Chain, formula: sp.Expr, quantity: Quantity | None = None) -> list[sp.Expr]:
    """Return a formula as it is and with sums of angles expanded; a determinant also as products of entries."""
    apart = sp.expand(sp.expand_trig(formula))
    ways = [formula, apart, sp.expand(formula)]
    if quantity is not None and quantity.name == "determinant" and generic.n == 2:
        (a, b), (c, d) = derive(generic).jacobian.tolist()
        ways.append(sp.expand(a * d) - sp.expand(b * c))
    return [way for way in dict.fromkeys(ways) if len(str(way)) <= 2 * LONGEST]


SELECTIONS = (
    ShortQuestion(
        "singular-configurations", "Which of these are singular?", "6.8", points=1.0, sample=_ask_configurations,
        form="selection", about="singular-angles", otherwise="it has no five configurations to choose from",
        shows=("singular-angles",),
    ),
    ShortQuestion(
        "dependence", "On which joints does it depend?", "6.4", sample=_ask_dependence, form="selection",
        about="jacobian", otherwise="what could be asked about depends on all joints, or on none",
    ),
    ShortQuestion(
        "equal-forms", "Which of these are the same?", "6.4", points=1.0, sample=_ask_forms, form="selection",
        about="jacobian", otherwise="no result of it is short and can be written in several ways",
        shows=("jacobian", "determinant"),
    ),
)  # fmt: skip
