"""Multiple-choice questions with four options: which is the position, the Jacobian, one of its columns, …?"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import Asked
from qdot.exercises.questions.screws import SOURCE
from qdot.exercises.questions.statics import make_load_symbols
from qdot.exercises.quizzes.asking import ShortQuestion
from qdot.exercises.quizzes.options import Options, offer_choice
from qdot.exercises.quizzes.wrong import Subject, make_four_options
from qdot.exercises.quizzes.wrong_sets import make_four_sets


@dataclass(frozen=True, kw_only=True)
class AboutSubject(Options):
    """The formulas offered as options, and what they are about."""

    subject: Subject


Subjects = Callable[[Chain, str], list[Subject]]
"""A function that returns the subjects (whole answer, column or entry) that options can be about.

Its arguments are the arm and the name of the question whose answer the options are variants of.
"""


def _take_whole_answer(_: Chain, base: str) -> list[Subject]:
    return [Subject(base)]


def _take_whole_answer_or_entry(chain: Chain, base: str) -> list[Subject]:
    """Return the whole position, and each coordinate in case the whole position is too long for an option."""
    return [Subject(base), *(Subject(base, None, row) for row in range(len(chain.linear_rows)))]


def _find_moving_columns(chain: Chain, base: str) -> list[Subject]:
    """Return the columns that depend on the configuration. The constant ones are obvious without a calculation."""
    matrix, joints = QUESTIONS[base].ask(chain, Stream("quiz"))[0].as_matrix(), set(chain.q)
    return [Subject(base, column) for column in range(matrix.cols) if matrix.col(column).free_symbols & joints]


def _find_moving_entries(chain: Chain, base: str) -> list[Subject]:
    """Return the entries of a vector that depend on the configuration."""
    vector, joints = QUESTIONS[base].ask(chain, Stream("quiz"))[0].as_matrix(), set(chain.q)
    return [Subject(base, None, row) for row in range(vector.rows) if vector[row].free_symbols & joints]


def _take_columns(chain: Chain, base: str) -> list[Subject]:
    return [Subject(base, column) for column in range(chain.n)]


def _take_columns_but_first(chain: Chain, base: str) -> list[Subject]:
    """Return all columns except the first, for which there are not three plausible wrong answers."""
    return _take_columns(chain, base)[1:]


def _ask_formula(chain: Chain, rng: Stream, subjects: Subjects, base: str) -> Asked | None:
    for subject in rng.permutation(subjects(chain, base)):
        options = make_four_options(chain, subject, rng)
        if options is not None:
            symbols = make_load_symbols(chain) if base == "joint-torques" else {}
            answer, offered = offer_choice(options, rng)
            return answer, AboutSubject(offered=offered, subject=subject, symbols=symbols)
    return None


def _ask_sets(chain: Chain, rng: Stream) -> Asked | None:
    options = make_four_sets(chain, rng)
    if options is None:
        return None
    answer, offered = offer_choice(options, rng)
    return answer, Options(offered=offered)


NO_FOUR = "there are no four options that are short and go together"


def _choose_formula(
    name: str, title: str, source: str, base: str, subjects: Subjects, template: str = "formula-choice"
) -> ShortQuestion:
    return ShortQuestion(
        name, title, source, sample=partial(_ask_formula, subjects=subjects, base=base), form="choice", about=base,
        otherwise=NO_FOUR, shows=(base,), template=template, speaks_of=QUESTIONS[base].speaks_of,
    )  # fmt: skip


CHOICES = (
    _choose_formula("position-choice", "Which position?", "6.1", "position", _take_whole_answer_or_entry),
    _choose_formula("jacobian-choice", "Which Jacobian?", "6.4", "jacobian", _take_whole_answer),
    _choose_formula("column-choice", "Which column?", "6.4", "jacobian", _find_moving_columns),
    _choose_formula("axis-choice", "Which joint axis?", "6.12", "joint-axes", _find_moving_columns),
    _choose_formula("vector-choice", "Which vector?", "6.13", "position-vectors", _find_moving_columns),
    _choose_formula("determinant-choice", "Which determinant?", "6.8", "determinant", _take_whole_answer),
    _choose_formula("inverse-jacobian-choice", "Which inverse?", "appendix", "inverse-jacobian", _take_whole_answer),
    _choose_formula("torque-choice", "Which joint torque?", "dual of 6.4", "joint-torques", _find_moving_entries),
    _choose_formula("screw-choice", "Which screw?", SOURCE, "home-screws", _take_columns, "screw-choice"),
    _choose_formula(
        "space-column-choice", "Which column of the space Jacobian?", SOURCE, "space-jacobian", _take_columns_but_first,
        "screw-choice",
    ),
    ShortQuestion(
        "singular-angles-choice", "Where is it singular?", "6.8", sample=_ask_sets, form="choice",
        about="singular-angles", otherwise=NO_FOUR, shows=("singular-angles",),
    ),
)  # fmt: skip
