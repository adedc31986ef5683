"""The definition of a question: how it is generated for an arm, when it applies, which questions it builds on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Answer, Choice, Expression, Matrix
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, SCREWS
from qdot.exercises.arm.derivation import TooLong, derive, symbolic_arm_of
from qdot.exercises.arm.derivation_graph import Change, Working, to_sympy_matrix
from qdot.exercises.arm.trigonometry import count_terms
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.questions.reference import TextbookStages, derive_reference

Option = TypeVar("Option")

MAX_JOINTS_FOR_INVERSE = 3
"""Maximum number of joints for which an inverse is worked out as formulas."""

CONVENTION_OBJECTIONS = {
    FRAMES: "it needs the frames of a DH table, but this arm is described by screw axes",
    FRAMES_OF_JOINTS: 'it applies only to arms with a modified table (convention = "modified-dh")',
    SCREWS: 'it applies only to arms described by screw axes (convention = "screws")',
}
"""Why a question does not apply to an arm, by the feature of its convention that the question needs."""

AnswerAndDetails = tuple[Answer, Details]
"""The answer, and the details that the wording also needs."""


def object_unless_square(chain: Chain) -> str | None:
    """Return the objection to an arm whose task Jacobian has no determinant."""
    if len(chain.task) != chain.n:
        return f"its Jacobian is {len(chain.task)} x {chain.n} for the task {', '.join(chain.task)}, not square"
    if derive(chain).symbolic_minors[0].is_zero:
        return "its determinant is zero everywhere"
    return None


MAX_TERMS = 30
"""Maximum number of terms of a result to work out by hand, in all entries together. Example 6.3 has 15."""


@lru_cache(maxsize=4096)
def _count_terms(generic: Chain, result_name: str) -> int:
    return count_terms(getattr(derive(generic), result_name))


def object_to_term_count(term_count: int) -> str | None:
    """Return the objection to a result with `term_count` terms, or None if it can be worked out by hand."""
    return f"it has {term_count} terms, too many to work out by hand" if term_count > MAX_TERMS else None


def make_length_objection(result_name: str) -> Callable[[Chain], str | None]:
    """Return a function that objects to arms for which a result of `Derivation` ("geometric", "z", …) is too long."""
    return lambda chain: object_to_term_count(_count_terms(symbolic_arm_of(chain).chain, result_name))


def make_size_objection(
    description: str, max_joints: int, count_terms_of: Callable[[Chain], int]
) -> Callable[[Chain], str | None]:
    """Return a function that objects to arms for which a result has too many joints or terms.

    `description` describes the result, with {n} for the number of joints.
    """

    def object_to_size(chain: Chain) -> str | None:
        if chain.n > max_joints:
            return f"{description.format(n=chain.n)} is too long to work out by hand"
        return object_to_term_count(count_terms_of(chain))

    return object_to_size


def object_to_inverse(chain: Chain) -> str | None:
    """Return the objection to arms whose task Jacobian is larger than 3 x 3 or has too many terms to be inverted."""
    if chain.n > MAX_JOINTS_FOR_INVERSE:
        return f"the inverse of a {chain.n} x {chain.n} Jacobian is too long to work out by hand"
    return make_length_objection("jacobian")(chain)


def object_to_point_before_last_link(chain: Chain) -> str | None:
    """Return the objection to arms whose tool point is not fixed in the last frame."""
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


StageFormula = Callable[[Working, Details], np.ndarray]
"""A function that computes an answer, (rows, columns, …) or (rows, …), from the stages of a derivation.

It works in any arithmetic.
"""

StageSubstitution = Callable[[np.ndarray], Mapping[str, Change]]
"""A function that returns how an answer, (rows, columns, …), changes the stages of a derivation."""

RowOrder = Callable[[Chain], Sequence[int]]
"""A function that returns the order in which rows are asked for, as indices of a stage's rows.

The order is its own inverse.
"""


def make_stage_formula(stage: str, row_order: RowOrder | None = None) -> StageFormula:
    """Return a formula whose value is a stage of the derivation: a matrix, a vector or a single number."""

    def formula(w: Working, _: Details) -> np.ndarray:
        values = np.asarray(w[stage])
        if row_order is not None:
            values = values[row_order(w.chain)]
        return values[None] if values.ndim == 1 else values

    return formula


def make_stage_substitution(stage: str, row_order: RowOrder | None = None) -> StageSubstitution:
    """Return a substitution that replaces a stage by an answer."""

    def substitute(answer: np.ndarray) -> Mapping[str, Change]:
        def change(w: Working, correct: np.ndarray) -> np.ndarray:
            ordered_rows = answer if row_order is None else answer[row_order(w.chain)]
            return np.asarray({1: ordered_rows[0, 0], 2: ordered_rows[:, 0], 3: ordered_rows}[np.ndim(correct)])

        return {stage: change}

    return substitute


def make_rate_product_formula(stage: str, row_order: RowOrder | None = None) -> StageFormula:
    """Return a formula that multiplies a stage, which is a Jacobian, by the joint rates."""
    jacobian = make_stage_formula(stage, row_order)
    return lambda w, details: apply_matrix(jacobian(w, details), w["joint rates"])


def make_column_substitution(stage: str, **other_changes: Change) -> StageSubstitution:
    """Return a substitution that replaces the first vectors of a stage by the columns of an answer.

    `other_changes` are changes of other stages.
    """
    return lambda rows: {
        stage: lambda _, right: np.concatenate([rows.swapaxes(0, 1), right[rows.shape[1] :]]),
        **other_changes,
    }


def shuffle_options(
    options: Sequence[Option], correct: Option, rng: Stream, describe: Callable[[Option], str] = str
) -> tuple[Choice, list[Option]]:
    """Return a choice between options in random order, described by `describe`, and the shuffled options."""
    shuffled = rng.permutation(options)
    return Choice(tuple(map(describe, shuffled)), shuffled.index(correct)), shuffled


RowAndColumnLabels = tuple[Sequence[str], Sequence[str]]
"""Labels of the rows and of the columns of a matrix: in typed form, or in LaTeX if they can't be typed."""


def make_jacobian_labels(label_rows: Callable[[Chain], Sequence[str]]) -> Callable[[Chain], RowAndColumnLabels]:
    """Return a function that labels a Jacobian: its rows by `label_rows`, and its columns by the joint rates."""
    return lambda chain: (label_rows(chain), name_joint_rates(chain))


_LATEX_MARKS_TO_REMOVE = str.maketrans("", "", "\\{}_")


def name_joint_rates(chain: Chain) -> tuple[str, ...]:
    """Return the names of the joint rates, as `solve` returns them: qd1, qd2, …"""
    return tuple(rate.name for rate in chain.rates)


def name_velocity_components(rows: Sequence[str]) -> list[str]:
    r"""Return the LaTeX names of components of a twist.

    >>> name_velocity_components(["vx", "wz"])
    ['v_{x}', '\\omega_{z}']
    """
    return [("v" if row[0] == "v" else r"\omega") + f"_{{{row[1]}}}" for row in rows]


@dataclass(frozen=True)
class Question:
    r"""A kind of question: what it asks for, to which arms it applies, and how its answer is derived and presented.

    If the answer is computed from stages of the derivation, these fields describe it:

    - `stage`: the answer is this stage, with its rows in `row_order`. A student's answer can then replace the stage.
      For any other formula, `formula` computes the answer from the stages, and `substitution` returns which stages an
      answer replaces.
    - `textbook_stages`: stages in textbook form, in addition to those of `reference.WRITTEN`. The reference answer is
      computed from these. If it should have another form, `reference` returns it.
    - `answer_type`: Matrix (also for a vector) or Expression.
    - `make_details`: returns what the wording needs in addition to the answer.

    Any other answer comes from `sample`, which returns None if it finds nothing to ask. If such a question also has a
    `formula`, the grader recognises what mistakes in the derivation lead to. If it has none, the grader recognises only
    mistakes in the answer itself.

    `objection` returns why the question makes no sense for an arm, or None. `too_long` returns why the answer is too
    long to work out by hand, or None. A short question of a quiz has a `form`. It shows the answers to the questions
    named in `shown_answers`, which are therefore not asked with it. The default `template` has the question's name.

    A student may label the entries of an answer by `typed_names`, and the columns of a matrix by `column_names`.
    `entry_names` are the names of the entries in LaTeX, and `row_and_column_labels` names the rows and columns.
    `is_made_of_jacobian` means that the answer is derived from a given J. `is_made_of_minors` means that it consists of
    minors of J: their formulas take minutes for many joints, and a single formula is a product whose factors are
    compared.

    `link_sums` is "links" if each entry is a sum over the links, and "columns of links" if each column has such sums.
    `link_sum_rows` are the rows with these sums, each with its axis (0 to 2). A `constant_last_row` is the same for all
    arms. Export formats with a box for each entry show it instead of boxes.

    The grader marks later parts on a student's own earlier results. `source_questions` has sets of questions from whose
    answers this one can be derived, in the order in which the grader tries them. The default is the set `needs`. If the
    answer is a set of conditions, it consists of the configurations at which the formula `zero_formula` is zero.

    The question applies to arms whose convention has the feature `required_feature`, a key of CONVENTION_OBJECTIONS, or
    to all arms if that is empty. `title_for` returns the title for an arm if `title` does not fit all arms. For
    example, some Jacobians are found without differentiation.
    """

    name: str
    title: str
    source: str
    _: KW_ONLY
    points: float = 1.0
    needs: tuple[str, ...] = ()
    stage: str = ""
    row_order: RowOrder | None = None
    formula: StageFormula | None = None
    substitution: StageSubstitution | None = None
    textbook_stages: TextbookStages = field(default_factory=dict, hash=False)
    reference: Callable[[Chain, Details], sp.Matrix] | None = None
    answer_type: type[Matrix] | type[Expression] = Matrix
    make_details: Callable[[Chain, Stream], Details] = lambda chain, rng: Details()
    sample: Callable[[Chain, Stream], AnswerAndDetails | None] | None = None
    objection: Callable[[Chain], str | None] = lambda chain: None
    too_long: Callable[[Chain], str | None] = lambda chain: None
    form: str = ""
    shown_answers: tuple[str, ...] = ()
    template: str = ""
    typed_names: Callable[[Chain], tuple[str, ...]] = lambda chain: ()
    entry_names: Callable[[Chain, Part], Sequence[str]] = lambda chain, part: ()
    column_names: Callable[[Chain], tuple[str, ...]] = lambda chain: ()
    row_and_column_labels: Callable[[Chain], RowAndColumnLabels] = lambda chain: ((), ())
    is_made_of_jacobian: bool = False
    is_made_of_minors: bool = False
    link_sums: Literal["", "links", "columns of links"] = ""
    link_sum_rows: Callable[[Chain], Sequence[tuple[int, int]]] = lambda chain: ()
    constant_last_row: tuple[str, ...] = ()
    source_questions: tuple[tuple[str, ...], ...] | None = None
    zero_formula: StageFormula | None = None
    required_feature: str = ""
    title_for: Callable[[Chain], str] | None = None

    def __post_init__(self) -> None:
        if self.stage:
            object.__setattr__(self, "formula", make_stage_formula(self.stage, self.row_order))
            object.__setattr__(self, "substitution", make_stage_substitution(self.stage, self.row_order))

    def ask(self, chain: Chain, rng: Stream) -> AnswerAndDetails:
        """Return the answer, and the details that the wording needs. Raises RuntimeError if there is nothing to ask."""
        if self.sample is not None:
            answer_and_details = self.sample(chain, rng)
            if answer_and_details is None:
                raise RuntimeError(f"question {self.name} finds no suitable answer for {chain}; please report this")
            return answer_and_details
        details = self.make_details(chain, rng)
        if self.reference is not None:
            matrix = self.reference(chain, details)
        else:
            assert self.formula is not None, self.name
            matrix = to_sympy_matrix(self.formula(derive_reference(chain, self.textbook_stages), details))
        return (Matrix(matrix) if self.answer_type is Matrix else Expression(matrix[0])), details

    @property
    def derivation_sources(self) -> tuple[tuple[str, ...], ...]:
        """The sets of questions from whose answers this one can be derived, in the order in which they are tried."""
        if self.source_questions is not None:
            return self.source_questions
        return (self.needs,) if self.needs else ()

    def heading(self, chain: Chain) -> str:
        """Return the title of the question for an arm."""
        return self.title if self.title_for is None else self.title_for(chain)

    @property
    def is_long_in_formulas(self) -> bool:
        """Whether the result is made of minors, whose formulas are too long for many joints."""
        return self.is_made_of_minors or self.zero_formula is not None

    def list_typed_names(self, chain: Chain, part: Part) -> tuple[str, ...]:
        """Return the names that a student may type for the entries of a vector, or for a single result: qd1, tau1."""
        rows, columns = part.shape or (1, 1)
        names = self.entry_names(chain, part) if columns == 1 else ()
        plain_names = (name.removeprefix(r"\text").translate(_LATEX_MARKS_TO_REMOVE) for name in names)
        labels = self.typed_names(chain) or tuple(plain_names)
        return labels if len(labels) == rows else ()

    @property
    def conventions(self) -> tuple[str, ...]:
        """The names of the conventions to whose arms the question applies."""
        return tuple(name for name, known in REGISTRY.items() if self.required_feature in {"", *known.features})

    def find_convention_objection(self, convention: str) -> str | None:
        """Return why the question does not apply to arms that are presented in a convention; None if it does."""
        return None if convention in self.conventions else CONVENTION_OBJECTIONS[self.required_feature]

    def find_obstacle(self, chain: Chain) -> str | None:
        """Return why the question can't be asked for an arm: it does not apply or is too long; None if it can."""
        return self.find_objection(chain) or self.too_long(chain)

    def find_applicability_objection(self, chain: Chain) -> str | None:
        """Return why the question makes no sense for an arm in a suitable convention, or None. Raises TooLong."""
        return self.objection(chain)

    def find_objection(self, chain: Chain) -> str | None:
        """Return why the question makes no sense for an arm or its answer can't be derived; None if neither."""
        try:
            return self.find_convention_objection(chain.convention) or self.find_applicability_objection(chain)
        except TooLong as error:
            return str(error)
