"""One right option out of four: which is the position, the Jacobian, a column of it, its determinant, …"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import Asked
from qdot.exercises.questions.screws import SOURCE
from qdot.exercises.questions.statics import load_symbols
from qdot.exercises.quizzes.asking import ShortQuestion
from qdot.exercises.quizzes.options import Options, choice_of
from qdot.exercises.quizzes.wrong import Subject, four_options
from qdot.exercises.quizzes.wrong_sets import four_sets


@dataclass(frozen=True, kw_only=True)
class AboutSubject(Options):
    """Formulas that are offered for a subject."""

    subject: Subject


Ask = Callable[[Chain, Stream], Asked | None]
Subjects = Callable[[Chain], list[Subject]]
"""What a question could be about on an arm."""


def _whole_answer(base: str) -> Subjects:
    return lambda _: [Subject(base)]


def _coordinates(chain: Chain) -> list[Subject]:
    """Return the position as a whole and, for arms where that is too long, each coordinate."""
    answer, _ = QUESTIONS["position"].ask(chain, Stream("quiz"))
    rows = range(0 if answer.shape is None else answer.shape[0])
    return [Subject("position"), *(Subject("position", None, row) for row in rows)]


def _moving_columns(base: str, of: str) -> Subjects:
    """Return the columns that depend on the configuration: the others can be seen without a calculation."""

    def subjects(chain: Chain) -> list[Subject]:
        matrix: sp.Matrix = getattr(derive(chain), of)
        joints = set(chain.q)
        return [Subject(base, column) for column in range(matrix.cols) if matrix.col(column).free_symbols & joints]

    return subjects


def _moving_torques(chain: Chain) -> list[Subject]:
    jacobian = derive(chain).jacobian
    joints = set(chain.q)
    return [Subject("joint-torques", None, row) for row in range(chain.n) if jacobian.col(row).free_symbols & joints]


def _make_ask(subjects: Subjects) -> Ask:
    def ask(chain: Chain, rng: Stream) -> Asked | None:
        for subject in rng.permutation(subjects(chain)):
            options = four_options(chain, subject, rng)
            if options is not None:
                symbols = load_symbols(chain) if subject.base == "joint-torques" else {}
                answer, offered = choice_of(options, rng)
                return answer, AboutSubject(offered=offered, subject=subject, symbols=symbols)
        return None

    return ask


def _screw_columns(base: str, first: int) -> Subjects:
    """Return the columns of screws from joint `first` on: nobody gets those before it wrong in three ways."""
    return lambda chain: [Subject(base, column) for column in range(first - 1, chain.n)]


def _ask_sets(chain: Chain, rng: Stream) -> Asked | None:
    options = four_sets(chain, rng)
    if options is None:
        return None
    answer, offered = choice_of(options, rng)
    return answer, Options(offered=offered)


NO_FOUR = "there are no four options that are short and go together"


def _object_to_screws(name: str, base: str, ask: Ask) -> Callable[[Chain], str | None]:
    @lru_cache(maxsize=2048)
    def object_to_arm(chain: Chain) -> str | None:
        """Look at the arm itself: its structure does not determine where it is at home."""
        by_axes = QUESTIONS[base].objects(chain) is None
        return NO_FOUR if by_axes and ask(chain, Stream(f"quiz/{name}")) is None else None

    return object_to_arm


def _formula_choice(name: str, title: str, source: str, base: str, subjects: Subjects) -> ShortQuestion:
    return ShortQuestion(
        name, title, source, sample=_make_ask(subjects), form="choice", about=base, otherwise=NO_FOUR, shows=(base,),
        template="formula-choice", speaks_of=QUESTIONS[base].speaks_of,
    )  # fmt: skip


def _screw_choice(name: str, title: str, base: str, first: int) -> ShortQuestion:
    choice = _formula_choice(name, title, SOURCE, base, _screw_columns(base, first))
    ask = _make_ask(_screw_columns(base, first))
    return replace(choice, template="screw-choice", objection=_object_to_screws(name, base, ask))


CHOICES = (
    _formula_choice("position-choice", "Which position?", "6.1", "position", _coordinates),
    _formula_choice("jacobian-choice", "Which Jacobian?", "6.4", "jacobian", _whole_answer("jacobian")),
    _formula_choice("column-choice", "Which column?", "6.4", "jacobian", _moving_columns("jacobian", "jacobian")),
    _formula_choice("axis-choice", "Which joint axis?", "6.12", "joint-axes", _moving_columns("joint-axes", "z")),
    _formula_choice(
        "vector-choice", "Which vector?", "6.13", "position-vectors", _moving_columns("position-vectors", "p_star")
    ),
    _formula_choice("determinant-choice", "Which determinant?", "6.8", "determinant", _whole_answer("determinant")),
    _formula_choice(
        "inverse-jacobian-choice", "Which inverse?", "appendix", "inverse-jacobian", _whole_answer("inverse-jacobian")
    ),
    _formula_choice("torque-choice", "Which joint torque?", "dual of 6.4", "joint-torques", _moving_torques),
    _screw_choice("screw-choice", "Which screw?", "home-screws", 1),
    _screw_choice("space-column-choice", "Which column of the space Jacobian?", "space-jacobian", 2),
    ShortQuestion(
        "singular-angles-choice", "Where is it singular?", "6.8", sample=_ask_sets, form="choice",
        about="singular-angles", otherwise=NO_FOUR, shows=("singular-angles",),
    ),
)  # fmt: skip
