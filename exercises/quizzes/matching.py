"""To each item its option: columns of the Jacobian to the joints that they belong to."""

from functools import lru_cache

from qdot.exercises.answers import Matching
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions.base import Asked
from qdot.exercises.quizzes.asking import ShortQuestion
from qdot.exercises.quizzes.options import OfferedOption, Options
from qdot.exercises.quizzes.wrong import Subject, all_differ, make_four_options

LONGEST, MOST = 260, 6
"""Characters of a column, and columns."""


def _ask_columns(chain: Chain, rng: Stream) -> Asked | None:
    """Choose the order of the columns; if there are few, add a column with a mistake."""
    if not 2 <= chain.n <= MOST or not _are_distinct(chain):
        return None
    jacobian = derive(chain).jacobian
    offered = [OfferedOption(jacobian.col(column)) for column in range(chain.n)]
    extra = _make_extra_column(chain, rng) if chain.n < MOST else None
    order = tuple(rng.permutation([*offered, *([] if extra is None else [extra])]))
    answer = Matching(
        tuple(f"joint {number}" for number in range(1, chain.n + 1)),
        tuple(option.text for option in order),
        tuple(order.index(option) for option in offered),
    )
    return answer, Options(offered=order)


def _make_extra_column(chain: Chain, rng: Stream) -> OfferedOption | None:
    """Return a wrong column that equals none of the right ones."""
    jacobian = derive(chain).jacobian
    columns = [jacobian.col(column) for column in range(chain.n)]
    for number in rng.permutation(range(chain.n)):
        for option in (make_four_options(chain, Subject("jacobian", number), rng) or ())[1:]:
            if all_differ(chain, [*columns, option.shown]) and len(option.text) <= LONGEST:
                return option
    return None


@lru_cache(maxsize=1024)
def _are_distinct(chain: Chain) -> bool:
    jacobian = derive(chain).jacobian
    columns = [jacobian.col(column) for column in range(chain.n)]
    return _is_short(structure(chain).chain) and all_differ(chain, columns)


@lru_cache(maxsize=1024)
def _is_short(generic: Chain) -> bool:
    """Tell whether the columns of the structure are short: all of its arms are asked or none."""
    jacobian = derive(generic).jacobian
    return all(len(OfferedOption(jacobian.col(column)).text) <= LONGEST for column in range(generic.n))


MATCHINGS = (
    ShortQuestion(
        "match-columns", "Which column belongs to which joint?", "6.12", points=1.0, sample=_ask_columns,
        form="matching", about="jacobian", otherwise="columns of its Jacobian are many, or long, or the same",
        shows=("jacobian",),
    ),
)  # fmt: skip
