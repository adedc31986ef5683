"""What a question kind is: how it is asked of an arm, when it applies, and what it builds on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal

import numpy as np

from qdot.exercises.answers import Answer
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, SCREWS
from qdot.exercises.arm.derivation import TooLong, derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working
from qdot.exercises.arm.trigonometry import count_terms
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, Part

BY_HAND = 3
"""Up to so many joints an inverse is written out."""

ASKED_OF = {
    FRAMES: "it is asked in the frames of a table, and this arm is told by its axes",
    FRAMES_OF_JOINTS: 'it is asked of arms with a modified table (convention = "modified-dh")',
    SCREWS: 'it is asked of arms that are told by their axes (convention = "screws")',
}
"""Of which arms a question is asked that speaks of what not every convention has."""

Asked = tuple[Answer, Details]
"""The answer, and what the wording needs beside it."""


def no_objection(chain: Chain) -> str | None:
    """Return no objection."""
    return None


def objection_unless_square(chain: Chain) -> str | None:
    """Return the objection to an arm whose task Jacobian has no determinant."""
    if len(chain.task) != chain.n:
        return f"its Jacobian is {len(chain.task)} x {chain.n} for the task {', '.join(chain.task)}, not square"
    if derive(chain).generic_minors[0].is_zero:
        return "its determinant is zero everywhere"
    return None


MOST_TERMS = 30
"""Terms that a result worked out by hand may have, all entries together; Example 6.3 has 15."""


def terms(chain: Chain, what: str) -> int:
    """Return the number of terms of a result of `Derivation` ("geometric", "z", …), multiplied out."""
    return _terms(structure(chain).chain, what)


@lru_cache(maxsize=4096)
def _terms(generic: Chain, what: str) -> int:
    return count_terms(getattr(derive(generic), what))


def objection_to_terms(count: int) -> str | None:
    """Return the objection to a result of so many terms, if they are too many for a person."""
    return f"it has {count} terms, too many to be worked out by hand" if count > MOST_TERMS else None


def objection_to_length(what: str) -> Callable[[Chain], str | None]:
    """Return the objection to arms for which a result is too long for a person."""
    return lambda chain: objection_to_terms(terms(chain, what))


def objection_to_inverse(chain: Chain) -> str | None:
    """Return the objection to arms whose task Jacobian can't be inverted by hand: up to 3 x 3, of few terms."""
    if chain.n > BY_HAND:
        return f"the inverse of a {chain.n} x {chain.n} Jacobian is too long to be worked out by hand"
    return objection_to_length("jacobian")(chain)


DUTIES = ("diagnosis", "follow-through", "platforms", "STACK")
"""What is done with the answers to every question, or is told why it can't be (`Question.without`)."""

Result = Callable[[Working, Part], np.ndarray]
"""How an answer comes out of a derivation: (rows, columns, …), or (rows, …) of a vector."""


def stage(name: str) -> Result:
    """Return that an answer is a stage of the derivation."""
    return lambda w, _: np.asarray(w[name])


def number(name: str) -> Result:
    """Return that an answer is a stage which is a single number."""
    return lambda w, _: np.asarray(w[name][None])


Substitution = Callable[[np.ndarray], Mapping[str, Change]]
"""What becomes of a derivation whose answer to a question is given, (rows, columns, …): the stages that change."""


def substitute_stage(name: str) -> Substitution:
    """Return that an answer is put in the place of a stage."""
    return lambda rows: {name: lambda *_: rows}


def substitute_vector(name: str) -> Substitution:
    """Return that the only column of an answer is put in the place of a stage."""
    return lambda rows: {name: lambda *_: rows[:, 0]}


def substitute_number(name: str) -> Substitution:
    """Return that the only entry of an answer is put in the place of a stage."""
    return lambda rows: {name: lambda *_: rows[0, 0]}


def substitute_columns(name: str, **also: Change) -> Substitution:
    """Return that the columns of an answer are the first vectors of a stage, whose others stay; `also` changes, too."""
    return lambda rows: {name: lambda _, right: np.concatenate([rows.swapaxes(0, 1), right[rows.shape[1] :]]), **also}


def no_names(chain: Chain, *_: object) -> tuple[str, ...]:
    """Return no names: entries are told by row and column."""
    return ()


Grid = tuple[Sequence[str], Sequence[str]]
"""What the rows and the columns of a matrix belong to: as it is typed, or in LaTeX where that can't be typed."""


def no_grid(chain: Chain) -> Grid:
    """Return nothing: rows and columns are not told apart by what they belong to."""
    return (), ()


def rates_to(rows: Callable[[Chain], Sequence[str]]) -> Callable[[Chain], Grid]:
    """Return the grid of a Jacobian to these components, whose columns belong to the joint rates."""
    return lambda chain: (rows(chain), joint_rates(chain))


def no_rows(chain: Chain) -> tuple[tuple[int, int], ...]:
    """Return no rows."""
    return ()


def first_three(chain: Chain) -> list[tuple[int, int]]:
    """Return the three linear rows of a Jacobian of six rows, each with its axis."""
    return [(axis, axis) for axis in range(3)]


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
    """A kind of question; `objection` returns why it makes no sense for an arm, `too_long` why it is too much by hand.

    Both return None if it can be asked. A short question of a quiz has a `form`, and shows the answers to the questions
    named in `shows`, which are therefore not asked beside it. The `template` is the one of its name, unless given.

    `result` computes the answer from a derivation, so that a mistake made there shows in the answer: without it, only
    the mistakes made with the answer itself are known, and no consequences of mistakes. A student may write the
    entries of an answer under `labels`, and the columns of a matrix under `columns`; `entry_names` are the names of the
    entries in LaTeX, and `grid` names the rows and columns. If it `is_made_of_jacobian`, J is given; if it
    `is_made_of_minors`, deriving it as formulas takes minutes for many joints, and a single formula is a product whose
    factors count.

    Sums over the links are looked for in the `linear_rows` of an answer, each with its axis (0 to 2): in an entry, or
    in columns of one link each. A `last_row` that is the same for all arms is shown where a platform has a box for each
    entry.

    Later parts are marked on a student's own earlier results: `substitutes` puts an answer in place of the stages of
    the derivation that it gives, and `follows` names the questions from whose answers this one is derived, in the order
    in which that is tried. The conditions of a set are where the result that `vanishes` does.

    It is asked of arms whose convention has what it `speaks_of`, one of ASKED_OF; of all if that is nothing.
    `without` tells of DUTIES that are not done, why: of a question that does not say so, a test finds the gap. It is
    `titled` by an arm for which the title would not be true, as of a Jacobian for which nothing is differentiated.
    """

    name: str
    title: str
    source: str
    ask: Callable[[Chain, Stream], Asked]
    needs: tuple[str, ...] = ()
    points: float = 1.0
    objection: Callable[[Chain], str | None] = no_objection
    too_long: Callable[[Chain], str | None] = no_objection
    form: str = ""
    shows: tuple[str, ...] = ()
    template: str = ""
    result: Result | None = None
    labels: Callable[[Chain], tuple[str, ...]] = no_names
    entry_names: Callable[[Chain, Part], Sequence[str]] = no_names
    columns: Callable[[Chain], tuple[str, ...]] = no_names
    grid: Callable[[Chain], Grid] = no_grid
    is_made_of_jacobian: bool = False
    is_made_of_minors: bool = False
    adds_up: Literal["", "links", "columns of links"] = ""
    linear_rows: Callable[[Chain], Sequence[tuple[int, int]]] = no_rows
    last_row: tuple[str, ...] = ()
    substitutes: Substitution | None = None
    follows: tuple[tuple[str, ...], ...] = ()
    vanishes: Result | None = None
    speaks_of: str = ""
    without: Mapping[str, str] = field(default_factory=dict)
    title_for: Callable[[Chain], str] | None = None

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
        """Return why it is not asked of arms that are told in a convention."""
        return None if convention in self.conventions else ASKED_OF[self.speaks_of]

    def refusal(self, chain: Chain) -> str | None:
        """Return why it is not asked of an arm, for one reason or the other."""
        return self.objects(chain) or self.too_long(chain)

    def objects(self, chain: Chain) -> str | None:
        """Return why it makes no sense for an arm, or can't be worked out."""
        try:
            return self.objection_to_convention(chain.convention) or self.objection(chain)
        except TooLong as error:
            return str(error)
