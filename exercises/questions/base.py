"""The definition of a question: how it is generated for an arm, when it applies, which questions it builds on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np
import sympy as sp

from qdot.exercises.answers import Answer, Choice, Expression, Matrix
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, SCREWS
from qdot.exercises.arm.derivation import TooLong, derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working, as_formulas
from qdot.exercises.arm.trigonometry import count_terms
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.questions.reference import Written, reference_working

Option = TypeVar("Option")

BY_HAND = 3
"""Maximum number of joints for which an inverse is worked out as formulas."""

ASKED_OF = {
    FRAMES: "it is asked in the frames of a table, and this arm is told by its axes",
    FRAMES_OF_JOINTS: 'it is asked of arms with a modified table (convention = "modified-dh")',
    SCREWS: 'it is asked of arms that are told by their axes (convention = "screws")',
}
"""Why a question does not apply to an arm, by the feature of its convention that the question needs."""

Asked = tuple[Answer, Details]
"""The answer, and the details that the wording also needs."""


def no_objection(chain: Chain) -> str | None:
    """Return None: the question applies to every arm."""
    return None


def no_details(chain: Chain, rng: Stream) -> Details:
    """Return no details: the wording needs nothing but the answer."""
    return Details()


def objection_unless_square(chain: Chain) -> str | None:
    """Return the objection to an arm whose task Jacobian has no determinant."""
    if len(chain.task) != chain.n:
        return f"its Jacobian is {len(chain.task)} x {chain.n} for the task {', '.join(chain.task)}, not square"
    if derive(chain).generic_minors[0].is_zero:
        return "its determinant is zero everywhere"
    return None


MOST_TERMS = 30
"""Maximum number of terms of a result to work out by hand, in all entries together. Example 6.3 has 15."""


@lru_cache(maxsize=4096)
def _count_terms(generic: Chain, result: str) -> int:
    return count_terms(getattr(derive(generic), result))


def objection_to_terms(count: int) -> str | None:
    """Return the objection to a result with `count` terms, or None if it can be worked out by hand."""
    return f"it has {count} terms, too many to be worked out by hand" if count > MOST_TERMS else None


def objection_to_length(result: str) -> Callable[[Chain], str | None]:
    """Return a function that objects to arms for which a result of `Derivation` ("geometric", "z", …) is too long."""
    return lambda chain: objection_to_terms(_count_terms(structure(chain).chain, result))


def objection_to_size(result: str, most_joints: int, count: Callable[[Chain], int]) -> Callable[[Chain], str | None]:
    """Return a function that objects to arms for which a result has too many joints or terms.

    `result` describes it, with {n} for the number of joints.
    """

    def object_to_size(chain: Chain) -> str | None:
        if chain.n > most_joints:
            return f"{result.format(n=chain.n)} is too long to be worked out by hand"
        return objection_to_terms(count(chain))

    return object_to_size


def objection_to_inverse(chain: Chain) -> str | None:
    """Return the objection to arms whose task Jacobian is larger than 3 x 3 or has too many terms to be inverted."""
    if chain.n > BY_HAND:
        return f"the inverse of a {chain.n} x {chain.n} Jacobian is too long to be worked out by hand"
    return objection_to_length("jacobian")(chain)


def objection_to_point(chain: Chain) -> str | None:
    """Return the objection to arms whose tool point is not fixed in the last frame."""
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


Formula = Callable[[Working, Details], np.ndarray]
"""A function that computes an answer, (rows, columns, …) or (rows, …), from the stages of a derivation.

It works in any arithmetic.
"""

Substitution = Callable[[np.ndarray], Mapping[str, Change]]
"""A function that returns how an answer, (rows, columns, …), changes the stages of a derivation."""

RowOrder = Callable[[Chain], Sequence[int]]
"""A function that returns the order in which rows are asked for, as indices of a stage's rows.

The order is its own inverse.
"""


def stage_formula(name: str, row_order: RowOrder | None = None) -> Formula:
    """Return a formula whose value is a stage of the derivation: a matrix, a vector or a single number."""

    def formula(w: Working, _: Details) -> np.ndarray:
        values = np.asarray(w[name])
        if row_order is not None:
            values = values[row_order(w.chain)]
        return values[None] if values.ndim == 1 else values

    return formula


def stage_substitution(name: str, row_order: RowOrder | None = None) -> Substitution:
    """Return a substitution that replaces a stage by an answer."""

    def substitute(rows: np.ndarray) -> Mapping[str, Change]:
        def change(w: Working, right: np.ndarray) -> np.ndarray:
            ordered_rows = rows if row_order is None else rows[row_order(w.chain)]
            return np.asarray({1: ordered_rows[0, 0], 2: ordered_rows[:, 0], 3: ordered_rows}[np.ndim(right)])

        return {name: change}

    return substitute


def times_rates(name: str, row_order: RowOrder | None = None) -> Formula:
    """Return a formula that multiplies a stage, which is a Jacobian, by the joint rates."""
    jacobian = stage_formula(name, row_order)
    return lambda w, details: apply_matrix(jacobian(w, details), w["joint rates"])


def substitute_columns(name: str, **also: Change) -> Substitution:
    """Return a substitution that replaces the first vectors of a stage by the columns of an answer.

    `also` are changes of other stages.
    """
    return lambda rows: {name: lambda _, right: np.concatenate([rows.swapaxes(0, 1), right[rows.shape[1] :]]), **also}


def shuffle_options(
    options: Sequence[Option], right: Option, rng: Stream, words: Callable[[Option], str] = str
) -> tuple[Choice, list[Option]]:
    """Return a choice between options in random order, described by `words`, and the shuffled options."""
    shuffled = rng.permutation(options)
    return Choice(tuple(map(words, shuffled)), shuffled.index(right)), shuffled


def nothing(*_: object) -> tuple[()]:
    """Return no names: texts refer to entries by row and column."""
    return ()


Grid = tuple[Sequence[str], Sequence[str]]
"""Labels of the rows and of the columns of a matrix: in typed form, or in LaTeX if they can't be typed."""


def no_grid(chain: Chain) -> Grid:
    """Return no names for rows and columns."""
    return (), ()


def rates_to(rows: Callable[[Chain], Sequence[str]]) -> Callable[[Chain], Grid]:
    """Return a function that labels a Jacobian: its rows by `rows`, and its columns by the joint rates."""
    return lambda chain: (rows(chain), joint_rates(chain))


_OF_LATEX = str.maketrans("", "", "\\{}_")


def joint_rates(chain: Chain) -> tuple[str, ...]:
    """Return the names of the joint rates, as `solve` returns them: qd1, qd2, …"""
    return tuple(rate.name for rate in chain.rates)


def velocities(rows: Sequence[str]) -> list[str]:
    r"""Return the LaTeX names of components of a twist.

    >>> velocities(["vx", "wz"])
    ['v_{x}', '\\omega_{z}']
    """
    return [("v" if row[0] == "v" else r"\omega") + f"_{{{row[1]}}}" for row in rows]


@dataclass(frozen=True)
class Question:
    r"""A kind of question: what it asks for, to which arms it applies, and how its answer is derived and presented.

    If the answer is computed from stages of the derivation, these fields describe it:

    - `stage`: the answer is this stage, with its rows in `row_order`. A student's answer can then replace the stage.
      For any other formula, `formula` computes the answer from the stages, and `substitutes` returns which stages an
      answer replaces.
    - `written`: stages in textbook form, in addition to those of `reference.WRITTEN`. The reference answer is computed
      from these. If it should have another form, `reference` returns it.
    - `answer_type`: Matrix (also for a vector) or Expression.
    - `details`: returns what the wording needs in addition to the answer.

    Any other answer comes from `sample`, which returns None if it finds nothing to ask. If such a question also has a
    `formula`, the grader recognises what mistakes in the derivation lead to. If it has none, the grader recognises only
    mistakes in the answer itself.

    `objection` returns why the question makes no sense for an arm, or None. `too_long` returns why the answer is too
    long to work out by hand, or None. A short question of a quiz has a `form`. It shows the answers to the questions
    named in `shows`, which are therefore not asked with it. The default `template` has the question's name.

    A student may label the entries of an answer by `labels`, and the columns of a matrix by `columns`. `entry_names`
    are the names of the entries in LaTeX, and `grid` names the rows and columns. `is_made_of_jacobian` means that the
    answer is derived from a given J. `is_made_of_minors` means that it consists of minors of J: their formulas take
    minutes for many joints, and a single formula is a product whose factors are compared.

    `adds_up` is "links" if each entry is a sum over the links, and "columns of links" if each column has such sums.
    `linear_rows` are the rows with these sums, each with its axis (0 to 2). A `last_row` is the same for all arms.
    Export formats with a box for each entry show it instead of boxes.

    The grader marks later parts on a student's own earlier results. `follows_from` has sets of questions from whose
    answers this one can be derived, in the order in which the grader tries them. The default is the set `needs`. If the
    answer is a set of conditions, it consists of the configurations at which the formula `vanishes` is zero.

    The question applies to arms whose convention has the feature `speaks_of`, one of ASKED_OF, or to all arms if that
    is empty. `title_for` returns the title for an arm if `title` does not fit all arms. For example, some Jacobians are
    found without differentiation.
    """

    name: str
    title: str
    source: str
    _: KW_ONLY
    points: float = 1.0
    needs: tuple[str, ...] = ()
    stage: str = ""
    row_order: RowOrder | None = None
    formula: Formula | None = None
    substitutes: Substitution | None = None
    written: Written = field(default_factory=dict, hash=False)
    reference: Callable[[Chain, Details], sp.Matrix] | None = None
    answer_type: type[Matrix] | type[Expression] = Matrix
    details: Callable[[Chain, Stream], Details] = no_details
    sample: Callable[[Chain, Stream], Asked | None] | None = None
    objection: Callable[[Chain], str | None] = no_objection
    too_long: Callable[[Chain], str | None] = no_objection
    form: str = ""
    shows: tuple[str, ...] = ()
    template: str = ""
    labels: Callable[[Chain], tuple[str, ...]] = nothing
    entry_names: Callable[[Chain, Part], Sequence[str]] = nothing
    columns: Callable[[Chain], tuple[str, ...]] = nothing
    grid: Callable[[Chain], Grid] = no_grid
    is_made_of_jacobian: bool = False
    is_made_of_minors: bool = False
    adds_up: Literal["", "links", "columns of links"] = ""
    linear_rows: Callable[[Chain], Sequence[tuple[int, int]]] = nothing
    last_row: tuple[str, ...] = ()
    follows_from: tuple[tuple[str, ...], ...] | None = None
    vanishes: Formula | None = None
    speaks_of: str = ""
    title_for: Callable[[Chain], str] | None = None

    def __post_init__(self) -> None:
        if self.stage:
            object.__setattr__(self, "formula", stage_formula(self.stage, self.row_order))
            object.__setattr__(self, "substitutes", stage_substitution(self.stage, self.row_order))

    def ask(self, chain: Chain, rng: Stream) -> Asked:
        """Return the answer, and the details that the wording needs. Raises RuntimeError if there is nothing to ask."""
        if self.sample is not None:
            answer_and_details = self.sample(chain, rng)
            if answer_and_details is None:
                raise RuntimeError(f"{self.name} finds nothing to ask of {chain}; please report this")
            return answer_and_details
        details = self.details(chain, rng)
        if self.reference is not None:
            matrix = self.reference(chain, details)
        else:
            assert self.formula is not None, self.name
            matrix = as_formulas(self.formula(reference_working(chain, self.written), details))
        return (Matrix(matrix) if self.answer_type is Matrix else Expression(matrix[0])), details

    @property
    def follows(self) -> tuple[tuple[str, ...], ...]:
        """The sets of questions from whose answers this one can be derived, in the order for the grader to try."""
        if self.follows_from is not None:
            return self.follows_from
        return (self.needs,) if self.needs else ()

    def heading(self, chain: Chain) -> str:
        """Return the title of the question for an arm."""
        return self.title if self.title_for is None else self.title_for(chain)

    @property
    def is_long(self) -> bool:
        """Whether the result is made of minors, whose formulas are too long for many joints."""
        return self.is_made_of_minors or self.vanishes is not None

    def typed_labels(self, chain: Chain, part: Part) -> tuple[str, ...]:
        """Return the names that a student may type for the entries of a vector, or for a single result: qd1, tau1."""
        labels = self.labels(chain) or tuple(
            name.removeprefix(r"\text").translate(_OF_LATEX)
            for name in self.entry_names(chain, part)
            if part.shape is None or part.shape[1] == 1
        )
        return labels if len(labels) == (1 if part.shape is None else part.shape[0]) else ()

    @property
    def conventions(self) -> tuple[str, ...]:
        """The names of the conventions to whose arms it applies."""
        return tuple(name for name, convention in REGISTRY.items() if {self.speaks_of} - {""} <= convention.has)

    def objection_to_convention(self, convention: str) -> str | None:
        """Return why it does not apply to arms that are presented in a convention, or None."""
        return None if convention in self.conventions else ASKED_OF[self.speaks_of]

    def refusal(self, chain: Chain) -> str | None:
        """Return why it can't be asked for an arm: it does not apply, or is too long. Return None if it can."""
        return self.objects(chain) or self.too_long(chain)

    def object_to_arm(self, chain: Chain) -> str | None:
        """Return why it makes no sense for an arm in a suitable convention, or None. Raises TooLong."""
        return self.objection(chain)

    def objects(self, chain: Chain) -> str | None:
        """Return why it makes no sense for an arm, or can't be derived, or None."""
        try:
            return self.objection_to_convention(chain.convention) or self.object_to_arm(chain)
        except TooLong as error:
            return str(error)
