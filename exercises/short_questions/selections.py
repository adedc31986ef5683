"""Questions that ask for all correct options: joints that change a result, and equal forms of a formula."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import AnswerAndDetails, find_determinant_objection
from qdot.exercises.reference_answers import Selection
from qdot.exercises.short_questions import wrong_formulas
from qdot.exercises.short_questions.options import OfferedOption, Options
from qdot.exercises.short_questions.short_question import ShortQuestion

OPTION_COUNT = 5
"""The number of options of a question about equal forms."""
MAX_CHARACTERS = wrong_formulas.MAX_CHARACTERS_PER_ENTRY
"""Maximum number of characters of a result with equal forms as options. An option may be twice as long."""
MAX_TRIES = 8
"""Maximum number of random sets of five options that are tried until all their texts differ."""


@dataclass(frozen=True)
class Quantity:
    """A result of the derivation: the determinant, a coordinate of the position, a column or an entry of J.

    `name` is "determinant", "position", or "column" (of J, also for an entry). `row` is the row of a coordinate (0 to
    2) or of an entry; it is None for a whole column.
    """

    name: str
    row: int | None = None
    column: int | None = None

    def derive_formulas(self, chain: Chain) -> sp.Matrix:
        """Return the formulas of the quantity as a column."""
        derivation = derive(chain)
        if self.name == "determinant":
            return sp.Matrix([derivation.determinant])
        if self.name == "position":
            return sp.Matrix([derivation.position[self.row]])
        column = derivation.jacobian.col(self.column)
        return column if self.row is None else sp.Matrix([column[self.row]])


def _list_determinant_if_square(chain: Chain) -> list[Quantity]:
    return [] if find_determinant_objection(chain) else [Quantity("determinant")]


# --- on which joints does it depend? ---


@dataclass(frozen=True, kw_only=True)
class QuantityDetails(Details):
    """Details of a question about a result of the derivation."""

    quantity: Quantity


def _ask_dependence(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose a result that depends on some joints, but not on all, and ask on which joints it depends."""
    coordinates = [Quantity("position", "xyz".index(axis)) for axis in chain.linear_axes]
    columns = [Quantity("column", column=column) for column in range(chain.n)]
    candidates = []
    for quantity in (*_list_determinant_if_square(chain), *coordinates, *columns):
        symbols = quantity.derive_formulas(chain).free_symbols
        joints = tuple(index for index, q in enumerate(chain.q) if q in symbols)
        if 0 < len(joints) < chain.n:
            candidates.append((quantity, joints))
    if not candidates:
        return None
    quantity, joints = rng.choice(candidates)
    return Selection(tuple(q.name for q in chain.q), joints), QuantityDetails(quantity=quantity)


# --- which of these forms are equal? ---


@dataclass(frozen=True, kw_only=True)
class EqualForms(Options):
    """Correct and wrong forms of a result of the derivation, offered as options."""

    quantity: Quantity


def _ask_equal_forms(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for quantity in rng.permutation(_find_short_quantities(chain)):
        options = _make_five_options(chain, quantity, rng)
        if options is not None:
            shuffled_options = tuple(rng.permutation(options))
            correct = tuple(index for index, option in enumerate(shuffled_options) if not option.blames)
            answer = Selection(tuple(option.text for option in shuffled_options), correct)
            return answer, EqualForms(offered_options=shuffled_options, quantity=quantity)
    return None


def _find_short_quantities(chain: Chain) -> list[Quantity]:
    """Return the results with one short formula that contains a sine or cosine."""

    def is_short(quantity: Quantity) -> bool:
        formula = quantity.derive_formulas(chain)[0]
        return bool(formula.has(sp.sin, sp.cos)) and len(str(formula)) <= MAX_CHARACTERS

    entries = [Quantity("column", row, column) for row in range(len(chain.task)) for column in range(chain.n)]
    return [*filter(is_short, [*_list_determinant_if_square(chain), *entries])]


def _make_five_options(chain: Chain, quantity: Quantity, rng: Stream) -> list[OfferedOption] | None:
    """Return five options: two or three correct forms of a result, and wrong ones; None if there are too few."""
    symbolic_chain, substitute = make_symbolic_arm(chain).chain, derive(chain).substitute_values
    correct_forms = _list_equal_forms(symbolic_chain, quantity.derive_formulas(symbolic_chain)[0], quantity)
    base_question = "determinant" if quantity.name == "determinant" else "jacobian"
    subject = wrong_formulas.OptionSubject(base_question, quantity.column, quantity.row)
    wrong_forms = [
        (form, blame)
        for formula, blame in wrong_formulas.find_wrong_formulas(symbolic_chain, subject)
        for form in _list_equal_forms(symbolic_chain, formula)
    ]
    if len(correct_forms) < 2 or len(wrong_forms) < 3:
        return None
    correct_count = min(rng.choice((2, 3)), len(correct_forms))
    for _ in range(MAX_TRIES):
        correct_options = [OfferedOption(substitute(form)) for form in rng.permutation(correct_forms)[:correct_count]]
        chosen_wrong_forms = rng.permutation(wrong_forms)[: OPTION_COUNT - correct_count]
        options = correct_options + [OfferedOption(substitute(form), (blame,)) for form, blame in chosen_wrong_forms]
        correct_matrix, *other_matrices = (sp.Matrix([option.content]) for option in options)
        are_wrong = (
            wrong_formulas.are_different_functions(chain, [correct_matrix, wrong_matrix])
            for wrong_matrix in other_matrices[correct_count - 1 :]
        )
        if len({option.text for option in options}) == OPTION_COUNT and all(are_wrong):
            return options
    return None


def _list_equal_forms(symbolic_chain: Chain, formula: sp.Expr, quantity: Quantity | None = None) -> list[sp.Expr]:
    """Return equal forms of a formula: unchanged, with products expanded, and with sums of angles expanded, too.

    Another form of a 2 x 2 determinant consists of products of entries. Forms that are too long are left out.
    """
    forms = [formula, sp.expand(sp.expand_trig(formula)), sp.expand(formula)]
    if quantity is not None and quantity.name == "determinant" and symbolic_chain.n == 2:
        (a, b), (c, d) = derive(symbolic_chain).jacobian.tolist()
        forms.append(sp.expand(a * d) - sp.expand(b * c))
    return [form for form in dict.fromkeys(forms) if len(str(form)) <= 2 * MAX_CHARACTERS]


SELECTION_QUESTIONS = (
    ShortQuestion(
        "dependence", "Which joints have an effect?", "6.4", sample=_ask_dependence, form="selection",
        base_question="jacobian", objection_if_sampling_fails="each suitable result depends on all joints, or on none",
    ),
    ShortQuestion(
        "equal-forms", "Which of these are equal?", "6.4", points=1.0, sample=_ask_equal_forms, form="selection",
        base_question="jacobian",
        objection_if_sampling_fails="it has no short result that can be written in several ways",
        shown_answers=("jacobian", "determinant"),
    ),
)  # fmt: skip
