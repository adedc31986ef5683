"""Mistakes that lead to wrong options in questions, or to wrong integers such as the size or rank of J."""

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
from qdot.exercises.questions.exact_configurations import compute_full_rank
from qdot.exercises.questions.rank import MeaningDetails
from qdot.exercises.questions.singular import KIND_OPTIONS
from qdot.exercises.reference_answers import Choice, Number


def _choose_wrong_option(part_kind: str, is_mistake: Callable[[Part, int, int], bool]) -> AnswerGenerator:
    """Return a function that yields answers with the wrong options to which a mistake leads.

    `is_mistake` returns whether the mistake leads to a wrong option. The arguments are the part, the index of the wrong
    option, and the index of the correct option.
    """

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Choice):
            correct_index = part.answer.correct
            for index in range(len(part.answer.options)):
                if index != correct_index and is_mistake(part, index, correct_index):
                    yield MistakenAnswer(replace(part.answer, correct=index))

    return generate


def _confuse_options(
    part_kind: str, option_texts: Mapping[str, str], confused_names: Collection[tuple[str, str]]
) -> AnswerGenerator:
    """Return a function that yields answers in which the correct option is confused with another option.

    `confused_names` has pairs of names: of the correct option, and of the option that is chosen instead. `option_texts`
    has the text of each option by its name.
    """
    names_by_text = {text: name for name, text in option_texts.items()}

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        options = part.answer_as(Choice).options
        return (names_by_text[options[correct_index]], names_by_text[options[chosen_index]]) in confused_names

    return _choose_wrong_option(part_kind, is_chosen)


def _confuse_statements(has_correct_meaning: bool) -> AnswerGenerator:
    """Return a function that yields answers with a wrong geometric meaning of a singularity.

    If `has_correct_meaning`, it yields answers with the correct meaning and the wrong kind instead.
    """

    def is_chosen(part: Part, chosen_index: int, correct_index: int) -> bool:
        options = part.details_as(MeaningDetails).options
        return (options[chosen_index].meaning is options[correct_index].meaning) is has_correct_meaning

    return _choose_wrong_option("singularity-meaning", is_chosen)


def _give_wrong_numbers(part_kind: str, list_numbers: Callable[[Chain, Part], Iterable[list[int]]]) -> AnswerGenerator:
    """Return a function that yields answers with the numbers that `list_numbers` gives, if they are wrong."""

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == part_kind and isinstance(part.answer, Number):
            for values in list_numbers(chain, part):
                if values != list(part.answer.reference):
                    yield MistakenAnswer(replace(part.answer, reference=sp.Matrix(values)))

    return generate


def _count_task_rows(part: Part) -> int:
    return len(part.details_as(TaskDetails).task)


def _list_full_rank_minus_one(chain: Chain, part: Part, rank_losses: Collection[int]) -> list[list[int]]:
    """Return the full rank minus one as a wrong rank if the correct loss of rank is one of `rank_losses`."""
    full_rank = compute_full_rank(chain)
    rank_loss = full_rank - int(part.answer_as(Number).reference[0])
    return [[full_rank - 1]] if rank_loss in rank_losses else []


def _miscount_rows(chain: Chain, part: Part) -> Iterator[list[int]]:
    """Yield wrong sizes of J, for which the orientation, the position, or both are counted as one component."""
    linear_count = sum(row[0] == "v" for row in part.details_as(TaskDetails).task)
    angular_count = _count_task_rows(part) - linear_count
    yield [linear_count + min(angular_count, 1), chain.n]
    yield [min(linear_count, 1) + angular_count, chain.n]
    yield [min(linear_count, 1) + min(angular_count, 1), chain.n]


_confuse_kinds = partial(_confuse_options, "singularity-type", KIND_OPTIONS)
_confuse_invertibility = partial(_confuse_options, "invertibility", INVERTIBILITY_ANSWERS)
_give_wrong_sizes = partial(_give_wrong_numbers, "jacobian-size")
_give_wrong_ranks = partial(_give_wrong_numbers, "rank")

ANSWERS: dict[str, AnswerGenerator] = {
    "boundary-and-internal": combine(
        _confuse_kinds({("boundary", "internal"), ("internal", "boundary")}),
        _confuse_statements(has_correct_meaning=True),
    ),
    "singular-taken-for-regular": combine(
        _confuse_kinds({("boundary", "regular"), ("internal", "regular")}),
        _confuse_invertibility({("singular", "regular")}),
    ),
    "regular-taken-for-singular": combine(
        _confuse_kinds({("regular", "boundary"), ("regular", "internal")}),
        _confuse_invertibility({("regular", "singular")}),
    ),
    "shape-of-jacobian": _confuse_invertibility(
        set(permutations(INVERTIBILITY_ANSWERS, 2)) - {("singular", "regular"), ("regular", "singular")}
    ),
    "meaning-of-other-singularity": _confuse_statements(has_correct_meaning=False),
    "size-transposed": _give_wrong_sizes(lambda chain, part: [[chain.n, _count_task_rows(part)]]),
    "size-of-own-task": _give_wrong_sizes(lambda chain, _: [[len(chain.task), chain.n]]),
    "size-six-rows": _give_wrong_sizes(lambda chain, _: [[6, chain.n]]),
    "size-square": _give_wrong_sizes(lambda chain, part: [[size, size] for size in (chain.n, _count_task_rows(part))]),
    "rank-full": _give_wrong_ranks(lambda chain, _: [[compute_full_rank(chain)]]),
    "rank-of-shape": _give_wrong_ranks(lambda chain, _: [[chain.n], [len(chain.task)]]),
    "rank-of-singular-configuration": _give_wrong_ranks(partial(_list_full_rank_minus_one, rank_losses=[0])),
    "rank-of-one-condition": _give_wrong_ranks(partial(_list_full_rank_minus_one, rank_losses=range(2, 7))),
    "rank-zero": _give_wrong_ranks(lambda chain, part: [[0]]),
    "orientation-as-one-component": _give_wrong_sizes(_miscount_rows),
}
