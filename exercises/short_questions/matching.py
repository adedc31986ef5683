"""Matching questions: assign columns of the Jacobian to the joints to which they belong."""

from functools import lru_cache

import sympy as sp

from qdot.exercises.answer_types import Matching
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.short_questions.asking import ShortQuestion
from qdot.exercises.short_questions.options import OfferedOption, Options
from qdot.exercises.short_questions.wrong import OptionSubject, are_different_functions, make_four_options

MAX_CHARACTERS, MAX_COLUMNS = 260, 6
"""Maximum number of characters of a column, and maximum number of columns."""


def _ask_columns(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Sample the order of the columns; add one wrong column if the maximum number allows it."""
    if not 2 <= chain.n <= MAX_COLUMNS or not _has_short_distinct_columns(chain):
        return None
    correct_options = list(map(OfferedOption, _list_columns(chain)))
    wrong_option = _make_extra_column(chain, rng) if chain.n < MAX_COLUMNS else None
    shuffled = tuple(rng.permutation([*correct_options, *filter(None, [wrong_option])]))
    answer = Matching(
        tuple(f"joint {number}" for number in range(1, chain.n + 1)),
        tuple(option.text for option in shuffled),
        tuple(shuffled.index(option) for option in correct_options),
    )
    return answer, Options(offered=shuffled)


def _list_columns(chain: Chain) -> list[sp.Matrix]:
    jacobian = derive(chain).jacobian
    return [jacobian.col(column) for column in range(chain.n)]


def _make_extra_column(chain: Chain, rng: Stream) -> OfferedOption | None:
    """Return a wrong column that differs from all the correct ones."""
    for number in rng.permutation(range(chain.n)):
        for option in (make_four_options(chain, OptionSubject("jacobian", number), rng) or ())[1:]:
            if (
                are_different_functions(chain, [*_list_columns(chain), option.shown])
                and len(option.text) <= MAX_CHARACTERS
            ):
                return option
    return None


@lru_cache(maxsize=1024)
def _has_short_distinct_columns(chain: Chain) -> bool:
    return _has_short_columns(symbolic_arm_of(chain).chain) and are_different_functions(chain, _list_columns(chain))


@lru_cache(maxsize=1024)
def _has_short_columns(generic: Chain) -> bool:
    """Return whether the columns of a structure are short; the question applies to all of its arms or to none."""
    return all(len(OfferedOption(column).text) <= MAX_CHARACTERS for column in _list_columns(generic))


MATCHING_QUESTIONS = (
    ShortQuestion(
        "match-columns", "Which column belongs to which joint?", "6.12", points=1.0, sample=_ask_columns,
        form="matching", base_question="jacobian",
        objection_if_nothing_found="its Jacobian has too many columns, or columns that are too long or equal",
        shown_answers=("jacobian",),
    ),
)  # fmt: skip
