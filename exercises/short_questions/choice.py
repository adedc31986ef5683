"""Questions with formulas or sets as options, such as "Which position?" and "Which column of J belongs to joint 2?".

Other options are Jacobians, determinants, inverses, screws and sets of singular configurations.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.inversion import make_load_symbols
from qdot.exercises.questions.screws import SCREWS_SOURCE
from qdot.exercises.reference_answers import Matching
from qdot.exercises.short_questions import wrong_formulas
from qdot.exercises.short_questions.options import OfferedOption, Options, offer_choice
from qdot.exercises.short_questions.short_question import ShortQuestion
from qdot.exercises.short_questions.wrong_formulas import OptionSubject
from qdot.exercises.short_questions.wrong_sets import make_four_sets
from qdot.exercises.singularities.singular_set import find_singular_set


@dataclass(frozen=True, kw_only=True)
class FormulaOptions(Options):
    """The formulas that are offered as options, and the `subject`, which is the result that they claim to show."""

    subject: OptionSubject


# --- one of four formulas or sets ---

SubjectFinder = Callable[[Chain, str], list[OptionSubject]]
"""A function of an arm and a question that returns the results to which the options can refer. Such a result is the
whole answer to the question, or a column or an entry of the answer.
"""


def _list_whole_answer(_: Chain, question: str) -> list[OptionSubject]:
    return [OptionSubject(question)]


def _list_position_subjects(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the whole position and, because it may be too long for an option, each coordinate."""
    return [OptionSubject(question), *(OptionSubject(question, row=row) for row in range(len(chain.linear_axes)))]


def _find_varying_columns(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the columns that depend on the configuration, because other columns need no calculation."""
    matrix = wrong_formulas.ask_base_question(chain, question).answer.as_matrix()
    return [OptionSubject(question, column=i) for i in range(matrix.cols) if matrix.col(i).has(*chain.q)]


def _find_varying_entries(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the entries of a vector that depend on the configuration."""
    vector = wrong_formulas.ask_base_question(chain, question).answer.as_matrix()
    return [OptionSubject(question, row=row) for row in range(vector.rows) if vector[row].has(*chain.q)]


def _list_columns(chain: Chain, question: str, first_column: int = 0) -> list[OptionSubject]:
    return [OptionSubject(question, column=column) for column in range(first_column, chain.n)]


def _ask_formula(chain: Chain, rng: Stream, find_subjects: SubjectFinder, question: str) -> AnswerAndDetails | None:
    for subject in rng.permutation(find_subjects(chain, question)):
        options = wrong_formulas.make_four_options(chain, subject, rng)
        if options is not None:
            symbols = make_load_symbols(chain) if question == "joint-torques" else {}
            answer, shuffled_options = offer_choice(options, rng)
            return answer, FormulaOptions(offered_options=shuffled_options, subject=subject, symbols=symbols)
    return None


def _ask_sets(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    correct_set = find_singular_set(chain)
    options = make_four_sets(chain, correct_set, rng) if correct_set else None
    if options is None:
        return None
    answer, shuffled_options = offer_choice(options, rng)
    return answer, Options(offered_options=shuffled_options)


NO_FOUR_OPTIONS = "it does not have four short options of similar length"


def _make_formula_question(
    name: str, title: str, source: str, base_question: str, find_subjects: SubjectFinder
) -> ShortQuestion:
    feature = QUESTIONS[base_question].required_feature
    return ShortQuestion(
        name, title, source, sample=partial(_ask_formula, find_subjects=find_subjects, question=base_question),
        form="choice", base_question=base_question, objection_if_sampling_fails=NO_FOUR_OPTIONS,
        shown_answers=(base_question,), required_feature=feature,
        template="screw-choice" if feature == SCREWS else "formula-choice",
    )  # fmt: skip


CHOICE_QUESTIONS = (
    _make_formula_question("position-choice", "Which position?", "6.1", "position", _list_position_subjects),
    _make_formula_question("jacobian-choice", "Which Jacobian?", "6.4", "jacobian", _list_whole_answer),
    _make_formula_question("column-choice", "Which column?", "6.4", "jacobian", _find_varying_columns),
    _make_formula_question("axis-choice", "Which joint axis?", "6.12", "joint-axes", _find_varying_columns),
    _make_formula_question("vector-choice", "Which vector?", "6.13", "position-vectors", _find_varying_columns),
    _make_formula_question("determinant-choice", "Which determinant?", "6.8", "determinant", _list_whole_answer),
    _make_formula_question(
        "inverse-jacobian-choice", "Which inverse?", "appendix", "inverse-jacobian", _list_whole_answer,
    ),
    _make_formula_question(
        "torque-choice", "Which joint torque?", "dual of 6.4", "joint-torques", _find_varying_entries,
    ),
    _make_formula_question("screw-choice", "Which screw?", SCREWS_SOURCE, "home-screws", _list_columns),
    _make_formula_question(
        "space-column-choice", "Which column of the space Jacobian?", SCREWS_SOURCE, "space-jacobian",
        partial(_list_columns, first_column=1),  # for the first column, there are no three plausible wrong options
    ),
    ShortQuestion(
        "singular-angles-choice", "Where is the arm singular?", "6.8", sample=_ask_sets, form="choice",
        base_question="singular-angles", objection_if_sampling_fails=NO_FOUR_OPTIONS,
        shown_answers=("singular-angles",),
    ),
)  # fmt: skip


# --- which column belongs to which joint? ---

MAX_CHARACTERS, MAX_COLUMNS = 260, 6
"""Maximum number of characters of a column, and maximum number of columns offered."""


def _ask_matching_columns(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer the columns in random order, and a wrong column if there are fewer than MAX_COLUMNS columns."""
    if not 2 <= chain.n <= MAX_COLUMNS or not _has_short_distinct_columns(chain):
        return None
    correct_options = list(map(OfferedOption, _split_columns(chain)))
    wrong_option = _make_extra_column(chain, rng) if chain.n < MAX_COLUMNS else None
    shuffled_options = tuple(rng.permutation([*correct_options, *filter(None, [wrong_option])]))
    answer = Matching(
        tuple(f"joint {number}" for number in range(1, chain.n + 1)),
        tuple(option.text for option in shuffled_options),
        tuple(shuffled_options.index(option) for option in correct_options),
    )
    return answer, Options(offered_options=shuffled_options)


def _split_columns(chain: Chain) -> list[sp.Matrix]:
    jacobian = derive(chain).jacobian
    return [jacobian.col(column) for column in range(chain.n)]


def _make_extra_column(chain: Chain, rng: Stream) -> OfferedOption | None:
    """Return a wrong column that differs from all correct columns, or None if none is found."""
    for column in rng.permutation(range(chain.n)):
        options = wrong_formulas.make_four_options(chain, OptionSubject("jacobian", column=column), rng) or ()
        for option in options[1:]:  # the first option is correct
            is_different = wrong_formulas.are_different_functions(chain, [*_split_columns(chain), option.content])
            if is_different and len(option.text) <= MAX_CHARACTERS:
                return option
    return None


@lru_cache(maxsize=1024)
def _has_short_distinct_columns(chain: Chain) -> bool:
    return _has_short_columns(make_symbolic_arm(chain).chain) and wrong_formulas.are_different_functions(
        chain, _split_columns(chain)
    )


@lru_cache(maxsize=1024)
def _has_short_columns(symbolic_chain: Chain) -> bool:
    """Return whether the columns of a symbolic arm are short."""
    return all(len(OfferedOption(column).text) <= MAX_CHARACTERS for column in _split_columns(symbolic_chain))


MATCH_COLUMNS = ShortQuestion(
    "match-columns", "Which column belongs to which joint?", "6.12", points=1.0, sample=_ask_matching_columns,
    form="matching", base_question="jacobian", shown_answers=("jacobian",),
    objection_if_sampling_fails="its Jacobian has too many columns, or columns that are too long or equal",
)  # fmt: skip
