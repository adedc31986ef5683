"""Multiple-choice questions with four options: which is the position, the Jacobian, one of its columns, …?"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.screws import SCREWS_SOURCE
from qdot.exercises.questions.statics import make_load_symbols
from qdot.exercises.short_questions.asking import ShortQuestion
from qdot.exercises.short_questions.options import Options, offer_choice
from qdot.exercises.short_questions.wrong import OptionSubject, make_four_options
from qdot.exercises.short_questions.wrong_sets import make_four_sets


@dataclass(frozen=True, kw_only=True)
class FormulaOptions(Options):
    """The formulas offered as options, and the result that they show."""

    subject: OptionSubject


SubjectFinder = Callable[[Chain, str], list[OptionSubject]]
"""A function that returns the subjects (whole answer, column or entry) that options can be about.

Its arguments are the arm and the name of the question whose answer the options are variants of.
"""


def _list_whole_answer(_: Chain, question: str) -> list[OptionSubject]:
    return [OptionSubject(question)]


def _list_whole_answer_and_entries(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the whole position, and each coordinate in case the whole position is too long for an option."""
    return [OptionSubject(question), *(OptionSubject(question, None, row) for row in range(len(chain.linear_axes)))]


def _find_varying_columns(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the columns that depend on the configuration. The constant ones are obvious without a calculation."""
    matrix = QUESTIONS[question].ask(chain, Stream("quiz"))[0].as_matrix()
    return [OptionSubject(question, i) for i in range(matrix.cols) if matrix.col(i).has(*chain.q)]


def _find_varying_entries(chain: Chain, question: str) -> list[OptionSubject]:
    """Return the entries of a vector that depend on the configuration."""
    vector = QUESTIONS[question].ask(chain, Stream("quiz"))[0].as_matrix()
    return [OptionSubject(question, None, row) for row in range(vector.rows) if vector[row].has(*chain.q)]


def _list_columns(chain: Chain, question: str) -> list[OptionSubject]:
    return [OptionSubject(question, column) for column in range(chain.n)]


def _list_columns_except_first(chain: Chain, question: str) -> list[OptionSubject]:
    """Return all columns except the first, which does not have three plausible wrong answers."""
    return _list_columns(chain, question)[1:]


def _ask_formula(chain: Chain, rng: Stream, find_subjects: SubjectFinder, question: str) -> AnswerAndDetails | None:
    for subject in rng.permutation(find_subjects(chain, question)):
        options = make_four_options(chain, subject, rng)
        if options is not None:
            symbols = make_load_symbols(chain) if question == "joint-torques" else {}
            answer, offered = offer_choice(options, rng)
            return answer, FormulaOptions(offered=offered, subject=subject, symbols=symbols)
    return None


def _ask_sets(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    options = make_four_sets(chain, rng)
    if options is None:
        return None
    answer, offered = offer_choice(options, rng)
    return answer, Options(offered=offered)


NO_FOUR_OPTIONS = "it does not have four short options of similar length"


def _make_formula_question(
    name: str, title: str, source: str, base_question: str, find_subjects: SubjectFinder
) -> ShortQuestion:
    feature = QUESTIONS[base_question].required_feature
    return ShortQuestion(
        name, title, source, sample=partial(_ask_formula, find_subjects=find_subjects, question=base_question),
        form="choice", base_question=base_question, objection_if_nothing_found=NO_FOUR_OPTIONS,
        shown_answers=(base_question,), required_feature=feature,
        template="screw-choice" if feature == SCREWS else "formula-choice",
    )  # fmt: skip


CHOICE_QUESTIONS = (
    _make_formula_question("position-choice", "Which position?", "6.1", "position", _list_whole_answer_and_entries),
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
        _list_columns_except_first,
    ),
    ShortQuestion(
        "singular-angles-choice", "Where is it singular?", "6.8", sample=_ask_sets, form="choice",
        base_question="singular-angles", objection_if_nothing_found=NO_FOUR_OPTIONS, shown_answers=("singular-angles",),
    ),
)  # fmt: skip
