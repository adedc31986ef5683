"""Mistakes that lead to wrong options of choice questions, or to wrong integers such as the size or rank of J."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import permutations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.mistakes.base import AnswerGenerator, MistakenAnswer, combine
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.concepts import INVERTIBILITY_ANSWERS
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.rank import MeaningDetails
from qdot.exercises.questions.singular import KIND_OPTIONS
from qdot.exercises.reference_answers import Choice, Number


def _choose_wrong_option(part_kind: str, is_mistake: Callable[[Part, int, int], bool]) -> AnswerGenerator:
    """Return a function that yields answers with the wrong options to which a mistake leads.

    `is_mistake` returns whether the mistake leads to a wrong option. Its arguments are the part, the index of the wrong
    option and the index of the correct option.
    """

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Choice):
            correct_index = part.answer.correct
            for index in range(len(part.answer.options)):
                if index != correct_index and is_mistake(part, index, correct_index):
                    yield MistakenAnswer(replace(part.answer, correct=index))

    return generate


def _confuse_meanings(
    part_kind: str, text_by_meaning: Mapping[str, str], confused_meanings: Collection[tuple[str, str]]
) -> AnswerGenerator:
    """Return a function that yields answers in which the correct meaning is confused with another meaning.

    `confused_meanings` are pairs of the correct meaning and the meaning that is chosen instead. `text_by_meaning` has
    the texts of the options.
    """
    meanings_by_text = {text: name for name, text in text_by_meaning.items()}

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        options = part.answer_as(Choice).options
        return (meanings_by_text[options[correct_index]], meanings_by_text[options[chosen_index]]) in confused_meanings

    return _choose_wrong_option(part_kind, is_chosen)


def _confuse_statements(is_same_meaning: bool) -> AnswerGenerator:
    """Return a function that yields answers with a wrong kind of singularity or a wrong geometric cause.

    If `is_same_meaning`, the geometric cause is correct and only the kind is wrong.
    """

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        offered = part.details_as(MeaningDetails).offered
        return (offered[chosen_index][0] is offered[correct_index][0]) is is_same_meaning

    return _choose_wrong_option("singularity-meaning", is_chosen)


def _give_wrong_numbers(part_kind: str, wrong_numbers: Callable[[Chain, Part], Iterable[list[int]]]) -> AnswerGenerator:
    """Return a function that yields answers with wrong integers."""

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Number):
            for values in wrong_numbers(chain, part):
                if values != list(part.answer.reference):
                    yield MistakenAnswer(replace(part.answer, reference=sp.Matrix(values)))

    return generate


def _count_task_rows(part: Part) -> int:
    return len(part.details_as(TaskDetails).task)


def _full_rank(chain: Chain) -> int:
    return min(len(chain.task), chain.n)


def _rank_loss(chain: Chain, part: Part) -> int:
    return _full_rank(chain) - int(part.answer_as(Number).reference[0])


def _miscount_rows(chain: Chain, part: Part) -> Iterator[list[int]]:
    """Yield the rows and columns of J, with the orientation or the position counted as a single component."""
    linear = sum(row[0] == "v" for row in part.details_as(TaskDetails).task)
    angular = _count_task_rows(part) - linear
    yield [linear + min(angular, 1), chain.n]
    yield [min(linear, 1) + angular, chain.n]
    yield [min(linear, 1) + min(angular, 1), chain.n]


_confuse_kinds = partial(_confuse_meanings, "singularity-type", KIND_OPTIONS)
_confuse_uses = partial(_confuse_meanings, "invertibility", INVERTIBILITY_ANSWERS)
_wrong_sizes = partial(_give_wrong_numbers, "jacobian-size")
_wrong_ranks = partial(_give_wrong_numbers, "rank")

ANSWERS: dict[str, AnswerGenerator] = {
    "boundary-and-internal": combine(
        _confuse_kinds({("boundary", "internal"), ("internal", "boundary")}), _confuse_statements(is_same_meaning=True)
    ),
    "singular-taken-for-regular": combine(
        _confuse_kinds({("boundary", "regular"), ("internal", "regular")}), _confuse_uses({("singular", "regular")})
    ),
    "regular-taken-for-singular": combine(
        _confuse_kinds({("regular", "boundary"), ("regular", "internal")}), _confuse_uses({("regular", "singular")})
    ),
    "shape-of-jacobian": _confuse_uses(
        set(permutations(INVERTIBILITY_ANSWERS, 2)) - {("singular", "regular"), ("regular", "singular")}
    ),
    "other-meaning": _confuse_statements(is_same_meaning=False),
    "direction-not-lost": _choose_wrong_option("lost-motion", lambda *_: True),
    "reachable-and-not": _choose_wrong_option("unreachable-velocity", lambda *_: True),
    "size-transposed": _wrong_sizes(lambda chain, part: [[chain.n, _count_task_rows(part)]]),
    "size-of-own-task": _wrong_sizes(lambda chain, _: [[len(chain.task), chain.n]]),
    "size-six-rows": _wrong_sizes(lambda chain, _: [[6, chain.n]]),
    "size-square": _wrong_sizes(lambda chain, part: [[size, size] for size in (chain.n, _count_task_rows(part))]),
    "rank-full": _wrong_ranks(lambda chain, _: [[_full_rank(chain)]]),
    "rank-of-shape": _wrong_ranks(lambda chain, _: [[chain.n], [len(chain.task)]]),
    "rank-less": _wrong_ranks(lambda chain, part: [[_full_rank(chain) - 1]] if _rank_loss(chain, part) == 0 else []),
    "rank-of-one-condition": _wrong_ranks(
        lambda chain, part: [[_full_rank(chain) - 1]] if _rank_loss(chain, part) > 1 else []
    ),
    "rank-zero": _wrong_ranks(lambda chain, part: [[0]]),
    "size-of-kinds": _wrong_sizes(_miscount_rows),
}
