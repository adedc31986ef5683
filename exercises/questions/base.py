"""What a question is: how it is asked of an arm, when it applies, and what it builds on."""

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
"""Up to so many joints an inverse is written out."""

ASKED_OF = {
    FRAMES: "it is asked in the frames of a table, and this arm is told by its axes",
    FRAMES_OF_JOINTS: 'it is asked of arms with a modified table (convention = "modified-dh")',
    SCREWS: 'it is asked of arms that are told by their axes (convention = "screws")',
}
"""Of which arms a question is asked that speaks of what not every convention has."""

Asked = tuple[Answer, Details]
"""The answer, and what the wording needs in addition."""


def no_objection(chain: Chain) -> str | None:
    """Return no objection."""
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
"""Terms that a result worked out by hand may have, all entries together; Example 6.3 has 15."""


@lru_cache(maxsize=4096)
def _count_terms(generic: Chain, result: str) -> int:
    return count_terms(getattr(derive(generic), result))


def objection_to_terms(count: int) -> str | None:
    """Return the objection to a result of so many terms, if they are too many for a person."""
    return f"it has {count} terms, too many to be worked out by hand" if count > MOST_TERMS else None


def objection_to_length(result: str) -> Callable[[Chain], str | None]:
    """Return the objection to arms for which a result of `Derivation` ("geometric", "z", …) is too long by hand."""
    return lambda chain: objection_to_terms(_count_terms(structure(chain).chain, result))


def objection_to_size(result: str, most_joints: int, count: Callable[[Chain], int]) -> Callable[[Chain], str | None]:
    """Return the objection to arms for which a result, "... of {n} joints ...", has too many joints or terms."""

    def object_to_size(chain: Chain) -> str | None:
        if chain.n > most_joints:
            return f"{result.format(n=chain.n)} is too long to be worked out by hand"
        return objection_to_terms(count(chain))

    return object_to_size


def objection_to_inverse(chain: Chain) -> str | None:
    """Return the objection to arms whose task Jacobian can't be inverted by hand: up to 3 x 3, of few terms."""
    if chain.n > BY_HAND:
        return f"the inverse of a {chain.n} x {chain.n} Jacobian is too long to be worked out by hand"
    return objection_to_length("jacobian")(chain)


def objection_to_point(chain: Chain) -> str | None:
    """Return the objection to arms whose point is not fixed in the last frame."""
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


Formula = Callable[[Working, Details], np.ndarray]
"""An answer as a formula over the stages of a derivation, in any arithmetic: (rows, columns, …), or (rows, …)."""

Substitution = Callable[[np.ndarray], Mapping[str, Change]]
"""The stages that change if an answer to a question, (rows, columns, …), is given."""

RowOrder = Callable[[Chain], Sequence[int]]
"""The order in which rows are asked for, as rows of a stage; applied twice, it gives the order of the stage again."""


def stage_formula(name: str, row_order: RowOrder | None = None) -> Formula:
    """Return the formula of an answer that is a stage of the derivation: a matrix, a vector or a single number."""

    def formula(w: Working, _: Details) -> np.ndarray:
        values = np.asarray(w[name])
        if row_order is not None:
            values = values[row_order(w.chain)]
        return values[None] if values.ndim == 1 else values

    return formula


def stage_substitution(name: str, row_order: RowOrder | None = None) -> Substitution:
    """Return how an answer takes the place of a stage."""

    def substitute(rows: np.ndarray) -> Mapping[str, Change]:
        def change(w: Working, right: np.ndarray) -> np.ndarray:
            in_order = rows if row_order is None else rows[row_order(w.chain)]
            return np.asarray({1: in_order[0, 0], 2: in_order[:, 0], 3: in_order}[np.ndim(right)])

        return {name: change}

    return substitute


def times_rates(name: str, row_order: RowOrder | None = None) -> Formula:
    """Return the formula of a Jacobian, which is a stage, times the joint rates."""
    jacobian = stage_formula(name, row_order)
    return lambda w, details: apply_matrix(jacobian(w, details), w["joint rates"])


def substitute_columns(name: str, **also: Change) -> Substitution:
    """Return how the columns of an answer replace the first vectors of a stage; `also` are more changes."""
    return lambda rows: {name: lambda _, right: np.concatenate([rows.swapaxes(0, 1), right[rows.shape[1] :]]), **also}


def shuffle_options(
    options: Sequence[Option], right: Option, rng: Stream, words: Callable[[Option], str] = str
) -> tuple[Choice, list[Option]]:
    """Return the choice between options in random order, described by `words`, and this order."""
    order = rng.permutation(options)
    return Choice(tuple(map(words, order)), order.index(right)), order


def nothing(*_: object) -> tuple[()]:
    """Return no names: entries are called by row and column."""
    return ()


Grid = tuple[Sequence[str], Sequence[str]]
"""What the rows and the columns of a matrix belong to: as it is typed, or in LaTeX where that can't be typed."""


def no_grid(chain: Chain) -> Grid:
    """Return no names for rows and columns."""
    return (), ()


def rates_to(rows: Callable[[Chain], Sequence[str]]) -> Callable[[Chain], Grid]:
    """Return the grid of a Jacobian to these components, whose columns belong to the joint rates."""
    return lambda chain: (rows(chain), joint_rates(chain))


_OF_LATEX = str.maketrans("", "", "\\{}_")


def joint_rates(chain: Chain) -> tuple[str, ...]:
    """Return the names of the joint rates, as `solve` returns them: qd1, qd2, …"""
    return tuple(rate.name for rate in chain.rates)


def velocities(rows: Sequence[str]) -> list[str]:
    r"""Return the LaTeX of components of a twist.

    >>> velocities(["vx", "wz"])
    ['v_{x}', '\\omega_{z}']
    """
    return [("v" if row[0] == "v" else r"\omega") + f"_{{{row[1]}}}" for row in rows]


@dataclass(frozen=True)
class Question:
    r"""A kind of question: what is asked of an arm, in which cases, and what else is known of its answer.

    An answer that is a formula over the stages of the derivation is described as data:

    - `stage`: the answer is this stage, with its rows in `row_order`; an answer may then also take its place. For any
      other formula, `formula` and `substitutes` say how it comes out of the stages and which stages it replaces.
    - `written`: stages as people read them, in addition to those of `reference.WRITTEN`; the reference is the formula
      over these. `reference` gives it where people read it in another form.
    - `answer_type` is Matrix, also for a vector, or Expression; `details` is what the wording needs in addition.

    Any other answer comes from `sample`, which returns None if it finds nothing to ask. It may have a `formula`, too,
    so that a mistake in the derivation shows in the answer: without one, only mistakes made with the answer itself are
    known, and no consequences of mistakes.

    `objection` returns why it makes no sense for an arm, `too_long` why it is too much by hand, or None. A short
    question of a quiz has a `form`, and shows the answers to the questions named in `shows`, which are therefore not
    asked with it. The `template` is the one of its name, unless given.

    A student may write the entries of an answer under `labels`, and the columns of a matrix under `columns`;
    `entry_names` are the names of the entries in LaTeX, and `grid` names the rows and columns. If it
    `is_made_of_jacobian`, J is given; if it `is_made_of_minors`, deriving it as formulas takes minutes for many joints,
    and a single formula is a product whose factors count.

    Sums over the links are looked for in the `linear_rows` of an answer, each with its axis (0 to 2): in an entry, or
    in columns of one link each. A `last_row` that is the same for all arms is shown where a platform has a box for each
    entry.

    Later parts are marked on a student's own earlier results: `follows_from` names the questions from whose answers
    this one is derived, in the order in which that is tried; unless given, they are those that it `needs`. The
    conditions of a set are where the result that `vanishes` does.

    It is asked of arms whose convention has what it `speaks_of`, one of ASKED_OF; of all arms if that is empty. Where
    `title` would be wrong, as for a Jacobian without differentiation, `title_for` returns the right one.
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
        """Return the answer, and what the wording needs in addition. Raises RuntimeError if there is nothing to ask."""
        if self.sample is not None:
            asked = self.sample(chain, rng)
            if asked is None:
                raise RuntimeError(f"{self.name} finds nothing to ask of {chain}; please report this")
            return asked
        details = self.details(chain, rng)
        if self.reference is not None:
            matrix = self.reference(chain, details)
        else:
            assert self.formula is not None, self.name
            matrix = as_formulas(self.formula(reference_working(chain, self.written), details))
        return (Matrix(matrix) if self.answer_type is Matrix else Expression(matrix[0])), details

    @property
    def follows(self) -> tuple[tuple[str, ...], ...]:
        """The questions from whose answers this one is derived, in the order in which that is tried."""
        if self.follows_from is not None:
            return self.follows_from
        return (self.needs,) if self.needs else ()

    def heading(self, chain: Chain) -> str:
        """Return the title over the question where it is asked of an arm."""
        return self.title if self.title_for is None else self.title_for(chain)

    @property
    def is_long(self) -> bool:
        """Whether the result is made of minors, which are too many in formulas for many joints."""
        return self.is_made_of_minors or self.vanishes is not None

    def typed_labels(self, chain: Chain, part: Part) -> tuple[str, ...]:
        """Return the names under which the entries of a vector, or the one result, may be typed: qd1, vx, tau1."""
        labels = self.labels(chain) or tuple(
            name.removeprefix(r"\text").translate(_OF_LATEX)
            for name in self.entry_names(chain, part)
            if part.shape is None or part.shape[1] == 1
        )
        return labels if len(labels) == (1 if part.shape is None else part.shape[0]) else ()

    @property
    def conventions(self) -> tuple[str, ...]:
        """The names of the conventions in which it is asked."""
        return tuple(name for name, convention in REGISTRY.items() if {self.speaks_of} - {""} <= convention.has)

    def objection_to_convention(self, convention: str) -> str | None:
        """Return why it is not asked of arms that are presented in a convention."""
        return None if convention in self.conventions else ASKED_OF[self.speaks_of]

    def refusal(self, chain: Chain) -> str | None:
        """Return why it is not asked of an arm, for one reason or the other."""
        return self.objects(chain) or self.too_long(chain)

    def object_to_arm(self, chain: Chain) -> str | None:
        """Return why it makes no sense for an arm of its conventions. Raises TooLong."""
        return self.objection(chain)

    def objects(self, chain: Chain) -> str | None:
        """Return why it makes no sense for an arm, or can't be worked out."""
        try:
            return self.objection_to_convention(chain.convention) or self.object_to_arm(chain)
        except TooLong as error:
            return str(error)
