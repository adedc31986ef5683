"""Questions that ask for all correct options: singular configurations, equal forms, joints that change a result."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answer_types import Selection
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import AnswerAndDetails, object_unless_square
from qdot.exercises.short_questions import places, wrong
from qdot.exercises.short_questions.asking import ShortQuestion
from qdot.exercises.short_questions.options import OfferedOption, Options
from qdot.exercises.short_questions.wrong import MAX_CHARACTERS_PER_ENTRY, OptionSubject

OPTION_COUNT = 5

# --- which of these configurations are singular? ---


def _ask_configurations(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for _ in range(4):
        arm, lengths = places.assign_random_lengths(chain, rng)
        singular_count = rng.choice((2, 3))
        singular = places.take_distinct(places.iterate_singular_configurations(arm, rng), singular_count)
        regular_count = OPTION_COUNT - len(singular)
        regular = places.take_distinct(places.iterate_regular_configurations(arm, rng), regular_count, singular)
        if len(singular) == singular_count and len(singular) + len(regular) == OPTION_COUNT:
            details, texts, correct = places.offer_configurations(singular, regular, lengths, rng)
            return Selection(texts, correct), details
    return None


# --- on which joints does it depend? ---


@dataclass(frozen=True)
class Quantity:
    """A result of the derivation: det J, a row of the position, a column or an entry of the task Jacobian."""

    name: str
    row: int | None = None
    column: int | None = None

    def derive_formulas(self, chain: Chain) -> sp.Matrix:
        """Return the formulas of the quantity as a column."""
        d = derive(chain)
        if self.name == "determinant":
            return sp.Matrix([d.determinant])
        if self.name == "position":
            return sp.Matrix([d.position[self.row]])
        column = d.jacobian.col(self.column)
        return column if self.row is None else sp.Matrix([column[self.row]])


@dataclass(frozen=True, kw_only=True)
class QuantityDetails(Details):
    """Details of a question about a result of the derivation."""

    quantity: Quantity


@dataclass(frozen=True, kw_only=True)
class EqualForms(Options):
    """Correct and wrong forms of a result of the derivation."""

    quantity: Quantity


def _list_determinant_if_square(chain: Chain) -> list[Quantity]:
    return [] if object_unless_square(chain) else [Quantity("determinant")]


def list_quantities(chain: Chain) -> list[Quantity]:
    """Return the results of an arm's derivation that can be asked about."""
    coordinates = [Quantity("position", "xyz".index(axis)) for axis in chain.linear_axes]
    columns = [Quantity("column", None, column) for column in range(chain.n)]
    return [*_list_determinant_if_square(chain), *coordinates, *columns]


def find_joints_with_influence(chain: Chain, quantity: Quantity) -> tuple[int, ...]:
    """Return the indices (from 0) of the joints on whose variables a quantity depends."""
    symbols = quantity.derive_formulas(chain).free_symbols
    return tuple(index for index, q in enumerate(chain.q) if q in symbols)


def _ask_dependence(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    influences = [(quantity, find_joints_with_influence(chain, quantity)) for quantity in list_quantities(chain)]
    partial_influences = [influence for influence in influences if 0 < len(influence[1]) < chain.n]
    if not partial_influences:
        return None
    quantity, joints = rng.choice(partial_influences)
    return Selection(tuple(q.name for q in chain.q), joints), QuantityDetails(quantity=quantity)


# --- which of these forms are equal? ---


def _ask_forms(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for quantity in rng.permutation(_find_short_quantities(chain)):
        offered = _make_five_options(chain, quantity, rng)
        if offered is not None:
            shuffled = tuple(rng.permutation(offered))
            correct = tuple(index for index, option in enumerate(shuffled) if not option.behind)
            answer = Selection(tuple(option.text for option in shuffled), correct)
            return answer, EqualForms(offered=shuffled, quantity=quantity)
    return None


def _find_short_quantities(chain: Chain) -> list[Quantity]:
    def is_short(quantity: Quantity) -> bool:
        formula = quantity.derive_formulas(chain)[0]
        return bool(formula.has(sp.sin, sp.cos)) and len(str(formula)) <= MAX_CHARACTERS_PER_ENTRY

    entries = [Quantity("column", row, column) for row in range(len(chain.task)) for column in range(chain.n)]
    return [*filter(is_short, [*_list_determinant_if_square(chain), *entries])]


def _make_five_options(chain: Chain, quantity: Quantity, rng: Stream) -> list[OfferedOption] | None:
    """Return five options: two or three correct forms of a result, and wrong ones; None if there are too few."""
    generic = symbolic_arm_of(chain).chain
    correct_forms = _list_equal_forms(generic, quantity.derive_formulas(generic)[0], quantity)
    base = "determinant" if quantity.name == "determinant" else "jacobian"
    subject = OptionSubject(base, quantity.column, quantity.row)
    wrong_formulas = wrong.list_wrong_forms(generic, subject)
    wrong_forms = [(form, blame) for formula, blame in wrong_formulas for form in _list_equal_forms(generic, formula)]
    if len(correct_forms) < 2 or len(wrong_forms) < 3:
        return None
    fill = derive(chain).substitute_values
    correct_count = min(rng.choice((2, 3)), len(correct_forms))
    for _ in range(8):
        correct_options = [OfferedOption(fill(form)) for form in rng.permutation(correct_forms)[:correct_count]]
        chosen_wrong_forms = rng.permutation(wrong_forms)[: OPTION_COUNT - correct_count]
        wrong_options = [OfferedOption(fill(form), (blame,)) for form, blame in chosen_wrong_forms]
        texts = {option.text for option in (*correct_options, *wrong_options)}
        correct, *wrongs = (sp.Matrix([option.shown]) for option in (correct_options[0], *wrong_options))
        are_wrong = (wrong.are_different_functions(chain, [correct, wrong_matrix]) for wrong_matrix in wrongs)
        if len(texts) == OPTION_COUNT and all(are_wrong):
            return [*correct_options, *wrong_options]
    return None


def _list_equal_forms(generic: Chain, formula: sp.Expr, quantity: Quantity | None = None) -> list[sp.Expr]:
    """Return equal forms of a formula: unchanged, with products expanded, and with sums of angles expanded, too.

    A 2 x 2 determinant is also returned as products of entries. Forms that are too long are left out.
    """
    expanded = sp.expand(sp.expand_trig(formula))
    forms = [formula, expanded, sp.expand(formula)]
    if quantity is not None and quantity.name == "determinant" and generic.n == 2:
        (a, b), (c, d) = derive(generic).jacobian.tolist()
        forms.append(sp.expand(a * d) - sp.expand(b * c))
    return [form for form in dict.fromkeys(forms) if len(str(form)) <= 2 * MAX_CHARACTERS_PER_ENTRY]


SELECTION_QUESTIONS = (
    ShortQuestion(
        "singular-configurations", "Which of these are singular?", "6.8", points=1.0, sample=_ask_configurations,
        form="selection", base_question="singular-angles",
        objection_if_nothing_found="it does not have five suitable configurations", shown_answers=("singular-angles",),
    ),
    ShortQuestion(
        "dependence", "On which joints does it depend?", "6.4", sample=_ask_dependence, form="selection",
        base_question="jacobian", objection_if_nothing_found="each suitable result depends on all joints, or on none",
    ),
    ShortQuestion(
        "equal-forms", "Which of these are the same?", "6.4", points=1.0, sample=_ask_forms, form="selection",
        base_question="jacobian",
        objection_if_nothing_found="it has no short result that can be written in several ways",
        shown_answers=("jacobian", "determinant"),
    ),
)  # fmt: skip
