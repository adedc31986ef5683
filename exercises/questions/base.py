"""Define what a question is: how its answer is derived, to which arms it applies, and on which questions it builds.

Answers are derived in stages, such as the joint axes, the Jacobian or its determinant (`derivation.graph`). In the
shapes of arrays, … is the axis of the arithmetic, such as one entry for each of several configurations. Results are
derived once for the structure of an arm, which is the arm with symbols for all lengths and oblique angles.
"""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import lru_cache, partial
from typing import Any, Literal, TypeVar

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, SCREWS
from qdot.exercises.arm.trigonometry import count_terms
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import apply_matrix
from qdot.exercises.derivation.derivation import TooLong, derive, make_symbolic_arm
from qdot.exercises.derivation.graph import Change, StageResults, propagate_linear_rows, to_sympy_matrix
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.questions.language import parse
from qdot.exercises.questions.quantities import STAGES_BY_NAME, compile_formula, select_components
from qdot.exercises.questions.reference import TextbookFormulas, derive_reference
from qdot.exercises.reference_answers import Answer, Choice, Expression, Matrix

Option = TypeVar("Option")

CONVENTION_OBJECTIONS = {
    FRAMES: "it needs the frames of a DH table, but this arm is described by screw axes",
    FRAMES_OF_JOINTS: 'it applies only to arms with a modified table (convention = "modified-dh")',
    SCREWS: 'it applies only to arms described by screw axes (convention = "screws")',
}
"""Maps the feature of a convention that a question needs to the objection to arms without this feature."""

AnswerAndDetails = tuple[Answer, Details]
"""The answer to a question, and the question's details: what it states or uses besides the answer."""

ObjectionFinder = Callable[[Chain], str | None]
"""A function that returns why a question can't be asked about an arm (an objection, as a clause about the arm), or
None."""


# --- objections to arms ---

MAX_TERMS = 30
"""Maximum number of terms, in all entries together, of a result to work out by hand. The result of Example 6.3 has
15."""

MAX_JOINTS_FOR_INVERSE = 3
"""Maximum number of joints for which an inverse is worked out as formulas."""


def find_determinant_objection(chain: Chain) -> str | None:
    """Return why the determinant of the task Jacobian can't be asked for, or None."""
    if not chain.has_square_jacobian:
        return f"its Jacobian is {len(chain.task)} x {chain.n} for the task {', '.join(chain.task)}, not square"
    return "its determinant is zero everywhere" if derive(chain).symbolic_minors[0].is_zero else None


def find_term_count_objection(term_count: int) -> str | None:
    """Return why a result with `term_count` terms can't be worked out by hand, or None."""
    return f"it has {term_count} terms, too many to work out by hand" if term_count > MAX_TERMS else None


@lru_cache(maxsize=4096)
def _count_terms(symbolic_chain: Chain, result_name: str) -> int:
    return count_terms(getattr(derive(symbolic_chain), result_name))


def limit_terms(result_name: str) -> ObjectionFinder:
    """Return a function that objects to an arm if a result of its `Derivation` ("jacobian", "z", …) is too long."""
    return lambda chain: find_term_count_objection(_count_terms(make_symbolic_arm(chain).chain, result_name))


def limit_size(description: str, max_joints: int, count: Callable[[Chain], int]) -> ObjectionFinder:
    """Return a function that objects to an arm if it has too many joints, or if a result has too many terms.

    `description` describes the result, with {n} for the number of joints. `count` returns the number of the result's
    terms.
    """

    def find_size_objection(chain: Chain) -> str | None:
        if chain.n > max_joints:
            return f"{description.format(n=chain.n)} is too long to work out by hand"
        return find_term_count_objection(count(chain))

    return find_size_objection


def find_inverse_size_objection(chain: Chain) -> str | None:
    """Return why the inverse of the task Jacobian is too long to work out by hand, or None."""
    if chain.n > MAX_JOINTS_FOR_INVERSE:
        return f"the inverse of a {chain.n} x {chain.n} Jacobian is too long to work out by hand"
    return limit_terms("jacobian")(chain)


def find_tool_point_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable (its point P is not fixed to the last frame), or None if it is suitable."""
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


# --- answers from stages of the derivation ---

StageFormula = Callable[[StageResults, Any], np.ndarray]
"""A function that computes an answer, (rows, columns, …) or (rows, …), from the stages and the question's details. The
entries are numbers, SymPy expressions or formula trees, as in the stages.
"""

StageSubstitution = Callable[[np.ndarray], Mapping[str, Change]]
"""A function of a student's answer, (rows, columns, …), that returns the changes of stages that replace the correct
results."""

RowOrder = Callable[[Chain], Sequence[int]]
"""A function that returns the order in which a question asks for the rows of a stage, as indices of these rows. The
permutation is its own inverse.
"""


def make_stage_formula(stage: str, row_order: RowOrder | None = None) -> StageFormula:
    """Return a function that returns a stage of the derivation: a matrix, a vector or a number."""

    def formula(stages: StageResults, _: Details) -> np.ndarray:
        values = np.asarray(stages[stage])
        values = values if row_order is None else values[row_order(stages.chain)]
        return values[None] if values.ndim == 1 else values

    return formula


def make_stage_substitution(stage: str, row_order: RowOrder | None = None) -> StageSubstitution:
    """Return a function that replaces a stage by a student's answer."""

    def substitute(answer: np.ndarray) -> Mapping[str, Change]:
        def change(stages: StageResults, correct: np.ndarray) -> np.ndarray:
            rows = answer if row_order is None else answer[row_order(stages.chain)]
            number, vector, matrix = rows[0, 0], rows[:, 0], rows
            return np.asarray((number, vector, matrix)[np.ndim(correct) - 1])

        return {stage: change}

    return substitute


def make_rate_product_formula(stage: str, row_order: RowOrder | None = None) -> StageFormula:
    """Return a function that multiplies a Jacobian, the result of a stage, by the joint rates."""
    jacobian = make_stage_formula(stage, row_order)
    return lambda stages, details: apply_matrix(jacobian(stages, details), stages["joint rates"])


def make_column_substitution(stage: str) -> StageSubstitution:
    """Return a function that replaces the first vectors of a stage by the columns of a student's answer.

    The linear rows of the Jacobian are then computed by propagation, from these vectors.
    """
    return lambda rows: {
        stage: lambda _, correct: np.concatenate([rows.swapaxes(0, 1), correct[rows.shape[1] :]]),
        "linear rows": propagate_linear_rows,
    }


# --- options and names ---


def shuffle_options(
    options: Sequence[Option], correct: Option, rng: Stream, describe: Callable[[Option], str] = str
) -> tuple[Choice, list[Option]]:
    """Return a choice between options in random order, and the options in that order.

    `describe` returns the text of an option.
    """
    shuffled_options = rng.permutation(options)
    return Choice(tuple(map(describe, shuffled_options)), shuffled_options.index(correct)), shuffled_options


RowAndColumnLabels = tuple[Sequence[str], Sequence[str]]
"""Labels of the rows and of the columns of a matrix: the names that students type, or LaTeX if there are none."""


def label_jacobian(label_rows: Callable[[Chain], Sequence[str]]) -> Callable[[Chain], RowAndColumnLabels]:
    """Return a function that labels the rows of a Jacobian by `label_rows`, and the columns by the joint rates."""
    return lambda chain: (label_rows(chain), name_joint_rates(chain))


_LATEX_MARKS_TO_REMOVE = str.maketrans("", "", "\\{}_")


def name_joint_rates(chain: Chain) -> tuple[str, ...]:
    """Return the names of the joint rates: qd1, qd2, …"""
    return tuple(rate.name for rate in chain.rates)


def name_velocity_components(rows: Sequence[str]) -> list[str]:
    r"""Return the LaTeX names of components of a twist.

    >>> name_velocity_components(["vx", "wz"])
    ['v_{x}', '\\omega_{z}']
    """
    return [("v" if row[0] == "v" else r"\omega") + f"_{{{row[1]}}}" for row in rows]


@dataclass(frozen=True)
class Question:
    r"""A question: what it asks for, to which arms it applies, and how its answer is derived and presented.

    `source` is the section of the chapter, such as 6.3, and `prerequisites` are the questions on which this question
    builds. `rounding` is the error that numbers may have; by default, numbers need three significant digits.

    If the answer is computed from stages of the derivation, these fields describe it:

    - `formula`: the answer in the language of custom questions (`language`), such as "p" or "inv(J)*xd". If
      `name_entries` names only some entries of a vector of three, the last letters of these names (x, y or z) say which
      components are asked for. If the language can't describe the answer, it is the result of `stage` with its rows in
      the order `row_order`, or `compute` computes it from the stages.
    - `differentiates_substitute`: whether the substitution needs derivatives of the student's answer.
    - `substitution`: returns the changes of stages that replace correct results by a student's answer. By default, the
      answer replaces the stage that is asked for.
    - `textbook_formulas`: formulas of stages in textbook form, in addition to `reference.TEXTBOOK_FORMULAS`. The
      reference answer is computed from them, unless `derive_matrix` returns it in another form.
    - `answer_type`: Matrix (also for a vector) or Expression.
    - `make_details`: returns what the question states or uses besides the answer.

    Any other answer comes from `sample`, which returns None if it finds nothing to ask. If the question also has a
    `formula`, a `stage` or `compute`, the grader recognises answers that are wrong because of a mistake in the
    derivation. Otherwise it recognises only mistakes in the answer itself.

    These functions return why the question can't be asked about an arm, or None: `find_arm_objection` if the question
    makes no sense, `find_size_objection` if the answer is too long to work out by hand.

    A short question of a quiz has a `form`, such as "choice" or "number". It shows the answers to the questions named
    in `shown_answers`, so a quiz does not ask these, too. By default, the `template` has the question's name.

    A student may label the entries of an answer with the names in `list_labels`, and the columns of a matrix with those
    in `name_columns`. `name_entries` returns the names of the entries in LaTeX.

    `is_made_of_jacobian` means that the answer is derived from a given J. `is_made_of_minors` means that it consists of
    minors of J, which take minutes to derive as formulas if there are many joints. If such an answer is a single
    formula, the grader compares it factor by factor.

    `link_sums` is "links" if each entry is a sum over the links, and "columns of links" if each column has such sums.
    `find_link_sum_rows` returns the rows with these sums, each with its axis (0 to 2). The `constant_last_row`, if any,
    is the same for all arms. Export formats with a box for each entry show this row without boxes.

    The grader also marks later parts against a student's own earlier results. `alternative_prerequisites` has sets of
    questions from whose answers this answer can be derived, in the order in which the grader tries them. The default is
    the set `prerequisites`. If the answer is a set of configurations, the formula `zero_formula` is zero at these, and
    `compute_zero` computes the value of this formula.

    The question applies to arms whose convention has the feature `required_feature`, a key of CONVENTION_OBJECTIONS, or
    to all arms if that is empty. `choose_title` returns the title for an arm if `title` does not fit all arms.
    """

    name: str
    title: str
    source: str
    _: KW_ONLY
    points: float = 1.0
    rounding: Rounding | None = None
    prerequisites: tuple[str, ...] = ()
    stage: str = ""
    row_order: RowOrder | None = None
    formula: str = ""
    compute: StageFormula | None = None
    substitution: StageSubstitution | None = None
    differentiates_substitute: bool = False
    textbook_formulas: TextbookFormulas = field(default_factory=dict, hash=False)
    derive_matrix: Callable[[Chain, Any], sp.Matrix] | None = None
    answer_type: type[Matrix] | type[Expression] = Matrix
    make_details: Callable[[Chain, Stream], Details] = lambda chain, rng: Details()
    sample: Callable[[Chain, Stream], AnswerAndDetails | None] | None = None
    find_arm_objection: ObjectionFinder = lambda chain: None
    find_size_objection: ObjectionFinder = lambda chain: None
    form: str = ""
    shown_answers: tuple[str, ...] = ()
    template: str = ""
    list_labels: Callable[[Chain], tuple[str, ...]] = lambda chain: ()
    name_entries: Callable[[Chain, Any], Sequence[str]] = lambda chain, details: ()
    name_columns: Callable[[Chain], tuple[str, ...]] = lambda chain: ()
    label_rows_and_columns: Callable[[Chain], RowAndColumnLabels] = lambda chain: ((), ())
    is_made_of_jacobian: bool = False
    is_made_of_minors: bool = False
    link_sums: Literal["", "links", "columns of links"] = ""
    find_link_sum_rows: Callable[[Chain], Sequence[tuple[int, int]]] = lambda chain: ()
    constant_last_row: tuple[str, ...] = ()
    alternative_prerequisites: tuple[tuple[str, ...], ...] | None = None
    zero_formula: str = ""
    compute_zero: StageFormula | None = None
    required_feature: str = ""
    choose_title: Callable[[Chain], str] | None = None

    def __post_init__(self) -> None:
        stage = self.stage
        if self.formula:
            tree = parse(self.formula)
            stage = STAGES_BY_NAME.get(ast.unparse(tree), "")
            object.__setattr__(self, "compute", partial(self._compute_formula, compile_formula(tree)))
        elif stage:
            object.__setattr__(self, "compute", make_stage_formula(stage, self.row_order))
        if stage and self.substitution is None:
            object.__setattr__(self, "substitution", make_stage_substitution(stage, self.row_order))
        if self.zero_formula:
            compute_zero = partial(self._compute_formula, compile_formula(parse(self.zero_formula)))
            object.__setattr__(self, "compute_zero", compute_zero)

    def _compute_formula(
        self, compute_value: Callable[[StageResults], np.ndarray], stages: StageResults, details: Any
    ) -> np.ndarray:
        value = select_components(compute_value(stages), self.name_entries(stages.chain, details))
        return value[None] if value.ndim == 1 else value

    @property
    def typed_formula(self) -> str:
        """The answer in the language of custom questions; "" if it is not described in this language."""
        return self.formula

    def ask(self, chain: Chain, rng: Stream) -> AnswerAndDetails:
        """Return the answer for an arm, and the details. Raises RuntimeError if there is nothing to ask."""
        if self.sample is not None:
            answer_and_details = self.sample(chain, rng)
            if answer_and_details is None:
                raise RuntimeError(f"question {self.name} finds no suitable answer for {chain}; please report this")
            return answer_and_details
        details = self.make_details(chain, rng)
        if self.derive_matrix is not None:
            matrix = self.derive_matrix(chain, details)
        else:
            assert self.compute is not None, self.name
            matrix = to_sympy_matrix(self.compute(derive_reference(chain, self.textbook_formulas), details))
        return (Matrix(matrix) if self.answer_type is Matrix else Expression(matrix[0])), details

    @property
    def prerequisite_sets(self) -> tuple[tuple[str, ...], ...]:
        """The sets of questions from whose answers this answer can be derived, in the order in which they are tried."""
        if self.alternative_prerequisites is not None:
            return self.alternative_prerequisites
        return (self.prerequisites,) if self.prerequisites else ()

    def make_title(self, chain: Chain) -> str:
        """Return the title of the question for an arm."""
        return self.title if self.choose_title is None else self.choose_title(chain)

    @property
    def is_long_in_formulas(self) -> bool:
        """Whether the answer comes from minors of J, whose formulas are too long if there are many joints."""
        return self.is_made_of_minors or self.zero_formula != ""

    def list_names_to_type(self, chain: Chain, part: Part) -> tuple[str, ...]:
        """Return the names that a student may type for the entries of a vector or for a single result, such as qd1."""
        rows, columns = part.shape or (1, 1)
        names = self.name_entries(chain, part.details) if columns == 1 else ()
        plain_names = (name.removeprefix(r"\text").translate(_LATEX_MARKS_TO_REMOVE) for name in names)
        labels = self.list_labels(chain) or tuple(plain_names)
        return labels if len(labels) == rows else ()

    @property
    def conventions(self) -> tuple[str, ...]:
        """The names of the conventions of the arms to which the question applies."""
        return tuple(
            name for name, convention in REGISTRY.items() if self.required_feature in {"", *convention.features}
        )

    def find_convention_objection(self, convention: str) -> str | None:
        """Return why the question does not apply to arms that are described in a convention; None if it does."""
        return None if convention in self.conventions else CONVENTION_OBJECTIONS[self.required_feature]

    def find_applicability_objection(self, chain: Chain) -> str | None:
        """Return why the question makes no sense for an arm in a suitable convention, or None. Raises TooLong."""
        return self.find_arm_objection(chain)

    def find_objection(self, chain: Chain) -> str | None:
        """Return why the question makes no sense for an arm, or why its answer can't be derived, or None."""
        try:
            return self.find_convention_objection(chain.convention) or self.find_applicability_objection(chain)
        except TooLong as error:
            return str(error)

    def find_obstacle(self, chain: Chain) -> str | None:
        """Return why the question can't be asked, for example because the answer is too long; None if it can."""
        return self.find_objection(chain) or self.find_size_objection(chain)
